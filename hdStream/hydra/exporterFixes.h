// SPDX-License-Identifier: Apache-2.0
// What a host's exporter is known to write otherwise than it is meant, turned back. A host asks for
// it by name (render setting `hostExporter`); docs/blender.md has the table.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

enum class HdStreamExporter {
    None,
    Blender, ///< both of Blender's exporters, 4.4 and 4.5
};

/// The exporter that a host names; None for names that are not known.
HdStreamExporter HdStreamFindExporter(const std::string& name);

/// Suns have a quarter of their strength. The blend of a spot is a share of a range of cosines,
/// and is handed over as UsdLux's softness, which is a share of the angle: the softness becomes the
/// one that lets the same flux of a small lamp through.
void HdStreamFixLight(HdStreamExporter exporter, hds::LightDescription* light);

/// The exporter of USD switches the colour temperature of all lamps on, and writes it where it is
/// not UsdLux's fallback of 6500 K, which is not white. Lamps that nobody has given one have just
/// that, so none is written of these: they get none.
void HdStreamFixTemperature(HdStreamExporter exporter, HdSceneDelegate* delegate, const SdfPath& id,
                            hds::LightDescription* light);

/// Principled's coat does not darken what it covers, and OpenPBR's does unless a node says
/// otherwise, which the exporter does not. The colour of glass is Principled's of the whole way in
/// and out, and is handed over as OpenPBR's, which dims at each surface: it becomes its root. A
/// Transparent BSDF is handed over twice, as opacity of the surface and as a white diffuse BSDF in
/// its place: the latter is taken out. The roughness of glossy, glass and refraction BSDFs is
/// handed over as MaterialX's, which is its square, and the tangent of Principled's anisotropy
/// turned by a quarter of a circle. An image that is in Blender's memory is written to a file of
/// the output's format and named as of the image's own colour space; where the format is linear
/// (EXR, Radiance), Blender has decoded it already.
void HdStreamFixMaterial(HdStreamExporter exporter, hds::MaterialNetwork* network);

PXR_NAMESPACE_CLOSE_SCOPE
