// SPDX-License-Identifier: Apache-2.0
// UsdPreviewSurface in double precision, written from the formulas of docs/shading.md and not from
// the kernel: the oracle of the kernel's tests.
#pragma once

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace hds::test {

constexpr double kReferencePi = 3.14159265358979323846;

/// Inputs of a surface, and which of its lobes are evaluated.
struct PreviewParameters {
    glm::dvec3 diffuseColor{0.18};
    glm::dvec3 specularColor{0.0};
    double metallic = 0.0;
    double roughness = 0.5;
    double clearcoat = 0.0;
    double clearcoatRoughness = 0.01;
    double opacity = 1.0;
    double opacityThreshold = 0.0;
    double ior = 1.5;
    bool isSpecularWorkflow = false;
    bool isLambert = false;

    /// As the test kernels read it: 16 floats.
    std::vector<float> Pack() const {
        return {float(diffuseColor.x),
                float(diffuseColor.y),
                float(diffuseColor.z),
                float(specularColor.x),
                float(specularColor.y),
                float(specularColor.z),
                float(metallic),
                float(roughness),
                float(clearcoat),
                float(clearcoatRoughness),
                float(opacity),
                float(opacityThreshold),
                float(ior),
                isSpecularWorkflow ? 1.0F : 0.0F,
                isLambert ? 1.0F : 0.0F,
                0.0F};
    }
};

/// OpenCL text that unpacks Pack() into an HdsSurface.
inline const char* const kUnpackSurface = R"(
#include "shading/previewSurface.clh"
HdsSurface unpackSurface(global const float* p, float3 geomNormal) {
    HdsPreviewInputs inputs;
    inputs.diffuseColor = vload3(0, p);
    inputs.emissiveColor = (float3)(0.0f);
    inputs.specularColor = vload3(1, p);
    inputs.metallic = p[6];
    inputs.roughness = p[7];
    inputs.clearcoat = p[8];
    inputs.clearcoatRoughness = p[9];
    inputs.opacity = p[10];
    inputs.opacityThreshold = p[11];
    inputs.ior = p[12];
    inputs.isSpecularWorkflow = p[13] > 0.0f;
    inputs.isLambert = p[14] > 0.0f;
    inputs.isPresence = 0u;
    HdsSurface surface;
    surface_setup(&surface, &inputs, geomNormal);
    return surface;
}
)";

/// The BSDF times the cosine, lobe by lobe.
class PreviewReference {
public:
    explicit PreviewReference(const PreviewParameters& p) {
        double opacity = p.opacity;
        if (p.opacityThreshold > 0.0) {
            opacity = p.opacity < p.opacityThreshold ? 0.0 : 1.0;
        }
        const glm::dvec3 color = p.diffuseColor * opacity;
        diffuse = color;
        if (p.isLambert) {
            return;
        }
        const double r = std::pow((1.0 - p.ior) / (1.0 + p.ior), 2.0);
        if (p.isSpecularWorkflow) {
            f0 = p.specularColor;
            f90 = glm::dvec3(1.0);
        } else {
            const glm::dvec3 specular = glm::mix(glm::dvec3(1.0), color, p.metallic);
            f0 = glm::mix(r * specular, specular, p.metallic);
            f90 = specular;
            diffuse *= 1.0 - p.metallic;
        }
        alpha = std::max(1e-4, p.roughness * p.roughness);
        coat = p.clearcoat;
        coatF0 = r;
        coatAlpha = std::max(1e-4, p.clearcoatRoughness * p.clearcoatRoughness);
    }

    glm::dvec3 diffuse{0.0};
    glm::dvec3 f0{0.0};
    glm::dvec3 f90{0.0};
    double alpha = 1.0;
    double coat = 0.0;
    double coatF0 = 0.0;
    double coatAlpha = 1.0;

    static double Schlick(double cosine) { return std::pow(1.0 - cosine, 5.0); }
    glm::dvec3 Fresnel(double cosine) const { return f0 + (f90 - f0) * Schlick(cosine); }
    double CoatFresnel(double cosine) const {
        return coat * (coatF0 + (1.0 - coatF0) * Schlick(cosine));
    }

    static double Distribution(double cosH, double a) {
        const double c2 = cosH * cosH;
        const double tan2 = (1.0 - c2) / c2;
        const double t = 1.0 + tan2 / (a * a);
        return 1.0 / (kReferencePi * a * a * c2 * c2 * t * t);
    }
    static double Lambda(double cosine, double a) {
        const double tan2 = (1.0 - cosine * cosine) / (cosine * cosine);
        return 0.5 * (std::sqrt(1.0 + a * a * tan2) - 1.0);
    }
    static double MaskingShadowing(double cosO, double cosI, double a) {
        return 1.0 / (1.0 + Lambda(cosO, a) + Lambda(cosI, a));
    }

    glm::dvec3 DiffuseLobe(const glm::dvec3& wo, const glm::dvec3& wi) const {
        const double e = glm::dot(wo, glm::normalize(wo + wi));
        return diffuse * (1.0 - Fresnel(e)) * (1.0 - CoatFresnel(e)) * (wi.z / kReferencePi);
    }
    glm::dvec3 SpecularLobe(const glm::dvec3& wo, const glm::dvec3& wi) const {
        const glm::dvec3 h = glm::normalize(wo + wi);
        const double e = glm::dot(wo, h);
        return Fresnel(e) * (1.0 - CoatFresnel(e)) * Distribution(h.z, alpha) *
               MaskingShadowing(wo.z, wi.z, alpha) / (4.0 * wo.z);
    }
    double CoatLobe(const glm::dvec3& wo, const glm::dvec3& wi) const {
        const glm::dvec3 h = glm::normalize(wo + wi);
        return CoatFresnel(glm::dot(wo, h)) * Distribution(h.z, coatAlpha) *
               MaskingShadowing(wo.z, wi.z, coatAlpha) / (4.0 * wo.z);
    }
    glm::dvec3 Evaluate(const glm::dvec3& wo, const glm::dvec3& wi) const {
        if (!(wo.z > 0.0 && wi.z > 0.0)) {
            return glm::dvec3(0.0);
        }
        return DiffuseLobe(wo, wi) + SpecularLobe(wo, wi) + CoatLobe(wo, wi);
    }

    /// Directional albedos by midpoint rules in double precision.
    /// Diffuse: over cosine-weighted directions.
    glm::dvec3 DiffuseAlbedo(double cosO) const {
        constexpr int kSteps = 256;
        const glm::dvec3 wo(std::sqrt(1.0 - cosO * cosO), 0.0, cosO);
        glm::dvec3 sum(0.0);
        for (int i = 0; i < kSteps; ++i) {
            const double r = std::sqrt((i + 0.5) / kSteps);
            const double z = std::sqrt(1.0 - r * r);
            for (int j = 0; j < kSteps; ++j) {
                const double phi = kReferencePi * (j + 0.5) / kSteps;
                const glm::dvec3 wi(r * std::cos(phi), r * std::sin(phi), z);
                sum += DiffuseLobe(wo, wi) * (kReferencePi / z);
            }
        }
        return sum / double(kSteps * kSteps);
    }
    glm::dvec3 SpecularAlbedo(double cosO) const {
        return MicrofacetAlbedo(cosO, alpha,
                                [&](double e) { return Fresnel(e) * (1.0 - CoatFresnel(e)); });
    }
    double CoatAlbedo(double cosO) const {
        return MicrofacetAlbedo(cosO, coatAlpha,
                                [&](double e) { return glm::dvec3(CoatFresnel(e)); })
            .x;
    }

private:
    /// Over microfacet normals, in phi (midpoints) and s = tan^2 / (alpha^2 + tan^2), in which D
    /// cos is the uniform measure whatever alpha. For each phi the normals that reflect upwards end
    /// at 2 theta = 90 degrees + atan2(sin(wo) cos(phi), cos(wo)); tanh-sinh quadrature (Takahasi
    /// and Mori 1974) takes the steep ends of that interval.
    static glm::dvec3 MicrofacetAlbedo(double cosO, double a,
                                       const std::function<glm::dvec3(double)>& fresnel) {
        constexpr int kPhiSteps = 512;
        constexpr int kSteps = 32;
        constexpr double kStep = 0.1;
        const double sinO = std::sqrt(1.0 - cosO * cosO);
        glm::dvec3 sum(0.0);
        for (int j = 0; j < kPhiSteps; ++j) {
            const double cosPhi = std::cos(kReferencePi * (j + 0.5) / kPhiSteps);
            const double end = 0.5 * (std::atan2(sinO * cosPhi, cosO) + 0.5 * kReferencePi);
            const double tanEnd = std::tan(end) / a;
            const double rest = 1.0 / (1.0 + tanEnd * tanEnd); // 1 - s at the end
            for (int k = -kSteps; k <= kSteps; ++k) {
                const double y = 0.5 * kReferencePi * std::sinh(k * kStep);
                const double above = 1.0 / (1.0 + std::exp(2.0 * y)); // 1 - x
                const double weight =
                    kStep * kReferencePi * std::cosh(k * kStep) * above * (1.0 - above);
                const double s = (1.0 - rest) / (1.0 + std::exp(-2.0 * y));
                const double tangent = a * std::sqrt(s / (rest + (1.0 - rest) * above));
                const double cosH = 1.0 / std::sqrt(1.0 + tangent * tangent);
                const double e = sinO * tangent * cosH * cosPhi + cosO * cosH;
                const double cosI = 2.0 * e * cosH - cosO;
                if (cosI > 0.0 && e > 0.0) {
                    sum += fresnel(e) * (MaskingShadowing(cosO, cosI, a) * e / (cosO * cosH) *
                                         weight * (1.0 - rest));
                }
            }
        }
        return sum / double(kPhiSteps);
    }
};

} // namespace hds::test
