# SPDX-License-Identifier: Apache-2.0
"""Methods of OpenUSD's objects as functions, for what is asked of each prim of a stage.

`prim.GetAttribute` first asks whether the prim is still there (UsdObject's __getattribute__), which takes longer than most of
what is asked then; functions of the class do not. Use them for objects of a stage that nobody edits meanwhile: they are not made
for those of prims that are gone.
"""

from pxr import Usd

GetAppliedSchemas = Usd.Prim.GetAppliedSchemas
GetAttribute = Usd.Prim.GetAttribute
GetAuthoredPropertyNames = Usd.Prim.GetAuthoredPropertyNames
GetFilteredChildren = Usd.Prim.GetFilteredChildren
GetName = Usd.Prim.GetName
GetParent = Usd.Prim.GetParent
GetPath = Usd.Prim.GetPath
GetTypeName = Usd.Prim.GetTypeName
HasAuthoredMetadata = Usd.Prim.HasAuthoredMetadata

GetColorSpace = Usd.Attribute.GetColorSpace
GetMetadata = Usd.Attribute.GetMetadata
GetPrimOf = Usd.Attribute.GetPrim
GetRoleName = Usd.Attribute.GetRoleName
GetValue = Usd.Attribute.Get
HasColorSpace = Usd.Attribute.HasColorSpace
