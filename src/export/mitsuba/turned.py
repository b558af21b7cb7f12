"""A BSDF for Mitsuba 3: scales whose ridges are turned over the surface, above a Lambertian base.

    value = share * scales(R(-angle) wi, R(-angle) wo) + base / pi * cos(theta_o)

R turns about the shading normal, counterclockwise. `scales` is a BSDF whose x lies across the ridges and y along them, as in the
`measured` files beside this one; at an angle of 0 its x is the direction in which the texture's u grows. Textures:

- `angle`: red (cos + 1) / 2 and green (sin + 1) / 2 of the angle, raw;
- `share`: how much of the light is that of the scales, raw;
- `base`: the base's reflectance.

`import turned`, with a variant of Mitsuba set, registers it as `turned`. Written for scalar variants.
"""

import math

import mitsuba as mi

# A direction shorter than this is none: its neighbours in the texture cancel each other.
NO_DIRECTION = 1e-6


class Turned(mi.BSDF):
    """See the head of this file."""

    def __init__(self, props):
        super().__init__(props)
        self.scales, self.angle = props["scales"], props["angle"]
        self.share, self.base = props["share"], props["base"]
        flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.Anisotropic
        flags = flags | mi.BSDFFlags.SpatiallyVarying
        self.m_components = [flags]
        self.m_flags = flags

    def traverse(self, callback):
        for name in ("scales", "angle", "share", "base"):
            callback.put(name, getattr(self, name), mi.ParamFlags.Differentiable)

    def ridges(self, si, active):
        """Cosine and sine of the angle."""
        level = self.angle.eval_3(si, active)
        cos, sin = 2 * level[0] - 1, 2 * level[1] - 1
        length = (cos * cos + sin * sin) ** 0.5
        return (cos / length, sin / length) if length > NO_DIRECTION else (1.0, 0.0)

    def seen_by_scales(self, si, ridges):
        """The point with its incident direction as the scales see it."""
        own = mi.SurfaceInteraction3f(si)
        own.wi = turned(si.wi, ridges, -1)
        return own

    def eval_pdf(self, ctx, si, wo, active=True):
        cos = wo.z
        if not active or si.wi.z <= 0 or cos <= 0:
            return mi.Spectrum(0), 0.0
        share = self.share.eval_1(si, active)
        value = self.base.eval(si, active) * (cos / math.pi)
        pdf = (1 - chance(share)) * mi.warp.square_to_cosine_hemisphere_pdf(wo)
        if share > 0:
            ridges = self.ridges(si, active)
            of_scales, pdf_of_scales = self.scales.eval_pdf(
                ctx, self.seen_by_scales(si, ridges), turned(wo, ridges, -1), active
            )
            value = value + share * of_scales
            pdf = pdf + chance(share) * pdf_of_scales
        return value, pdf

    def eval(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active=True):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def sample(self, ctx, si, sample1, sample2, active=True):
        share = self.share.eval_1(si, active)
        found = mi.BSDFSample3f()
        nothing = found, mi.Spectrum(0)
        if not active or si.wi.z <= 0:
            return nothing
        of_scales = chance(share)
        if sample1 < of_scales:
            ridges = self.ridges(si, active)
            found, _ = self.scales.sample(ctx, self.seen_by_scales(si, ridges), sample1 / of_scales, sample2, active)
            found.wo = turned(found.wo, ridges, 1)
        else:
            found.wo = mi.warp.square_to_cosine_hemisphere(sample2)
        value, found.pdf = self.eval_pdf(ctx, si, found.wo, active)
        if found.pdf <= 0:
            return nothing
        found.eta = 1.0
        found.sampled_type = +self.m_flags
        found.sampled_component = 0
        return found, value / found.pdf

    def to_string(self):
        return f"Turned[{self.scales}]"


def chance(share):
    """Share of the samples that are those of the scales."""
    return 0.5 if 0 < share < 1 else float(share > 0) * 0.9


def turned(direction, ridges, sense):
    """The direction turned about the normal: counterclockwise by the angle for a sense of 1, back for -1."""
    cos, sin = ridges[0], sense * ridges[1]
    return mi.Vector3f(cos * direction.x - sin * direction.y, sin * direction.x + cos * direction.y, direction.z)


mi.register_bsdf("turned", Turned)
