// SPDX-License-Identifier: Apache-2.0
// Of the façade, for front ends that translate materials: what a network is told of the frame.
#pragma once

#include "hdStream/shading/hostFrame.h"
