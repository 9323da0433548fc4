/* SPDX-License-Identifier: Apache-2.0
 * How much the index of glass changes with the wavelength: one over its Abbe number, in the flags
 * of a material. Explained in docs/materials.md. */
#ifndef HDS_SHARED_DISPERSION_H
#define HDS_SHARED_DISPERSION_H
#include "shared/compat.h"

/* Bits 17 to 31 of HdsMaterial.flags: exponent and leading bits of a float from 2^-14 to 2; 0:
 * none. */
#define HDS_MATERIAL_DISPERSION_SHIFT 17

HDS_SHARED_BEGIN
/* The least and the greatest that is told apart; a float's bits above those that are cut off. */
#define HDS_DISPERSION_FIRST 0x38800000u /* 2^-14 */
#define HDS_DISPERSION_CUT 13

HDS_FUNCTION float dispersion_ofFlags(u32 flags) {
    const u32 bits = flags >> HDS_MATERIAL_DISPERSION_SHIFT;
    return bits == 0u ? 0.0f : HDS_AS_FLOAT((bits << HDS_DISPERSION_CUT) + HDS_DISPERSION_FIRST);
}
HDS_SHARED_END

#endif
