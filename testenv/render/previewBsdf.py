# SPDX-License-Identifier: Apache-2.0
"""UsdPreviewSurface as a Mitsuba 3 BSDF plug-in in Python, for vectorised variants.

The formula is OpenUSD's preview shader (pxr/usdImaging/plugin/usdShaders/shaders/previewSurface.glslfx,
evaluateLight) with the exact lobes hdStream documents instead of the shader's approximations: GGX with
height-correlated Smith shadowing (Heitz 2014, JCGT 3(2), eq. 99) and a base that receives what the
clearcoat lets through. Written from the formula, not from hdStream's kernels. Import after a variant
is set; `Register()` names the plug-in "usdpreview".
"""

import drjit as dr
import mitsuba as mi

_COLORS = ("diffuseColor", "specularColor")
_SCALARS = ("metallic", "roughness", "clearcoat", "clearcoatRoughness", "opacity", "opacityThreshold", "ior")


def _GgxD(h, alpha):
    """With the half vector's own components: 1 - cosH^2 would lose all digits for small alpha."""
    d = (h.x * h.x + h.y * h.y) / (alpha * alpha) + h.z * h.z
    return dr.rcp(dr.pi * alpha * alpha * d * d)


def _SmithLambda(cosine, alpha):
    c2 = cosine * cosine
    return 0.5 * (dr.sqrt(1 + alpha * alpha * dr.maximum(1 - c2, 0) / c2) - 1)


def _GgxValue(cosV, cosL, h, alpha):
    """D * G2 / (4 cosV), that is, the lobe without Fresnel times cosL."""
    g2 = dr.rcp(1 + _SmithLambda(cosV, alpha) + _SmithLambda(cosL, alpha))
    return _GgxD(h, alpha) * g2 / (4 * cosV)


def _GgxPdf(cosV, h, alpha):
    """Density over directions of visible-normal sampling: D G1 / (4 cosV)."""
    return _GgxD(h, alpha) / ((1 + _SmithLambda(cosV, alpha)) * 4 * cosV)


def _SampleVisibleNormal(v, alpha, u):
    """Source: Heitz 2018, JCGT 7(4), listing 1."""
    vh = dr.normalize(mi.Vector3f(alpha * v.x, alpha * v.y, v.z))
    length2 = vh.x * vh.x + vh.y * vh.y
    t1 = dr.select(length2 > 0, mi.Vector3f(-vh.y, vh.x, 0) * dr.rsqrt(dr.maximum(length2, 1e-30)), mi.Vector3f(1, 0, 0))
    t2 = dr.cross(vh, t1)
    r, phi = dr.sqrt(u.x), 2 * dr.pi * u.y
    p1, p2 = r * dr.cos(phi), r * dr.sin(phi)
    s = 0.5 * (1 + vh.z)
    p2 = (1 - s) * dr.safe_sqrt(1 - p1 * p1) + s * p2
    n = t1 * p1 + t2 * p2 + vh * dr.safe_sqrt(1 - p1 * p1 - p2 * p2)
    return dr.normalize(mi.Vector3f(alpha * n.x, alpha * n.y, dr.maximum(n.z, 1e-6)))


def _Schlick(f0, f90, cosine):
    return dr.lerp(f0, f90, dr.maximum(1 - cosine, 0) ** 5)


class PreviewSurface(mi.BSDF):
    """Both-sided: the side that `wi` is on (of the geometric normal) is the front."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.textures = {name: props.get_texture(name, 0.0) for name in _COLORS}
        self.textures.update({name: props[name] for name in _SCALARS})
        self.specularWorkflow = bool(props["useSpecularWorkflow"])
        self.lambert = bool(props["lambert"])
        self.normal = mi.ScalarVector3f(*[props[f"normal{axis}"] for axis in "XYZ"])
        reflection = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        null = mi.BSDFFlags.Null | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [reflection, null]
        self.m_flags = reflection | null

    def _Inputs(self, si, active):
        values = {}
        for name, texture in self.textures.items():
            if isinstance(texture, mi.Texture):
                values[name] = texture.eval(si, active) if name in _COLORS else texture.eval_1(si, active)
            else:
                values[name] = mi.Float(texture)
        threshold, opacity = values["opacityThreshold"], values["opacity"]
        cut = dr.select(opacity < threshold, mi.Float(0), mi.Float(1))
        values["opacity"] = dr.select(threshold > 0, cut, opacity)
        values["cutAway"] = (threshold > 0) & (cut == 0)
        color, metallic, r = values["diffuseColor"], values["metallic"], (1 - values["ior"]) / (1 + values["ior"])
        values["coatF0"] = r * r
        if self.specularWorkflow:
            values["f0"], values["f90"], values["diffuse"] = values["specularColor"], mi.Color3f(1), color
        else:
            tint = dr.lerp(mi.Color3f(1), color, metallic)
            values["f0"], values["f90"] = dr.lerp(r * r * tint, tint, metallic), tint
            values["diffuse"] = color * (1 - metallic)
        if self.lambert:
            values["f0"] = values["f90"] = mi.Color3f(0)
        values["diffuse"] = values["diffuse"] * values["opacity"]
        values["alpha"] = dr.maximum(dr.square(values["roughness"]), 1e-4)
        values["coatAlpha"] = dr.maximum(dr.square(values["clearcoatRoughness"]), 1e-4)
        return values

    def _Frame(self, si):
        """The shading frame on the side of wi, and the geometric normal on that side (world)."""
        wi = si.to_world(si.wi)
        n = self.normal
        local = si.sh_frame.s * n.x + si.sh_frame.t * n.y + si.sh_frame.n * n.z
        side = dr.select(dr.dot(wi, si.n) < 0, mi.Float(-1), mi.Float(1))
        return mi.Frame3f(dr.normalize(local) * side), si.n * side

    def _Chances(self, values, transparent):
        """Probabilities of (diffuse, specular, coat, straight through)."""
        mean = lambda c: (c.x + c.y + c.z) / 3
        pass_ = dr.select(values["cutAway"], mi.Float(1), dr.clip(mean(transparent), 0, 0.95))
        diffuse, specular = mean(values["diffuse"]) + 0.02, 0.15 + 0.85 * mean(values["f0"])
        if self.lambert:
            specular = mi.Float(0)
        coat = dr.select(values["clearcoat"] > 0, 0.25 * values["clearcoat"] + 0.1, mi.Float(0))
        scale = (1 - pass_) / (diffuse + specular + coat)
        return diffuse * scale, specular * scale, coat * scale, pass_

    def _Transparent(self, values, v):
        """Straight-through transmittance (1 - opacity)(1 - F(NdotV)); 1 where cut away."""
        soft = (1 - values["opacity"]) * (1 - _Schlick(values["f0"], values["f90"], dr.abs(v.z)))
        return dr.select(values["cutAway"], mi.Color3f(1), dr.select(values["opacityThreshold"] > 0, mi.Color3f(0), soft))

    def _Evaluate(self, values, v, l, chances, active):
        """(value * cosine, pdf) of the reflecting lobes for local directions above the surface."""
        h = dr.normalize(v + l)
        cosVH = dr.maximum(dr.dot(v, h), 0)
        fresnel = _Schlick(values["f0"], values["f90"], cosVH)
        coat = values["clearcoat"] * _Schlick(values["coatF0"], mi.Float(1), cosVH)
        value = values["diffuse"] * (1 - fresnel) * (l.z / dr.pi)
        value += fresnel * _GgxValue(v.z, l.z, h, values["alpha"])
        value = value * (1 - coat) + coat * _GgxValue(v.z, l.z, h, values["coatAlpha"])
        pdf = chances[0] * l.z / dr.pi + chances[1] * _GgxPdf(v.z, h, values["alpha"])
        pdf += chances[2] * _GgxPdf(v.z, h, values["coatAlpha"])
        good = active & (v.z > 0) & (l.z > 0) & ~values["cutAway"]
        return dr.select(good, value, 0), dr.select(good, pdf, 0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        values = self._Inputs(si, active)
        frame, geometric = self._Frame(si)
        v = frame.to_local(si.to_world(si.wi))
        transparent = self._Transparent(values, v)
        chances = self._Chances(values, transparent)
        passes = sample1 < chances[3]
        diffuse = ~passes & (sample1 < chances[3] + chances[0])
        coat = ~passes & (sample1 >= chances[3] + chances[0] + chances[1])
        alpha = dr.select(coat, values["coatAlpha"], values["alpha"])
        h = _SampleVisibleNormal(mi.Vector3f(v.x, v.y, dr.maximum(v.z, 1e-6)), alpha, sample2)
        l = dr.select(diffuse, mi.warp.square_to_cosine_hemisphere(sample2), 2 * dr.dot(v, h) * h - v)
        world = frame.to_world(l)
        value, pdf = self._Evaluate(values, v, l, chances, active & (dr.dot(world, geometric) > 0))
        bs = mi.BSDFSample3f()
        bs.wo = dr.select(passes, -si.wi, si.to_local(world))
        bs.pdf = dr.select(passes, chances[3], pdf)
        bs.eta = mi.Float(1)
        bs.sampled_type = dr.select(passes, mi.UInt32(+mi.BSDFFlags.Null), mi.UInt32(+mi.BSDFFlags.GlossyReflection))
        bs.sampled_component = dr.select(passes, mi.UInt32(1), mi.UInt32(0))
        weight = dr.select(passes, transparent / dr.maximum(chances[3], 1e-8), value / dr.maximum(pdf, 1e-20))
        return bs, dr.select(active & (bs.pdf > 0), weight, 0)

    def eval_pdf(self, ctx, si, wo, active=True):
        values = self._Inputs(si, active)
        frame, geometric = self._Frame(si)
        v, world = frame.to_local(si.to_world(si.wi)), si.to_world(wo)
        chances = self._Chances(values, self._Transparent(values, v))
        return self._Evaluate(values, v, frame.to_local(world), chances, active & (dr.dot(world, geometric) > 0))

    def eval(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def eval_null_transmission(self, si, active=True):
        values = self._Inputs(si, active)
        frame, _ = self._Frame(si)
        return self._Transparent(values, frame.to_local(si.to_world(si.wi)))

    def to_string(self):
        return "PreviewSurface[]"


def Register() -> None:
    mi.register_bsdf("usdpreview", PreviewSurface)
