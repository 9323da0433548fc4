// SPDX-License-Identifier: Apache-2.0
// Hair (kernels/shading/hair.clh) in double precision, written apart from the papers' formulas:
// angles in place of vectors, the Bessel function of the standard library, the residual lobe as the
// series that it stands for, the logistic by its distribution function. And how tests hand
// parameters to the kernel.
#pragma once

#include "kernels/shared/material.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace hds::test {

/// A fibre, and where it is seen.
struct HairParameters {
    std::array<double, 3> variance{0.1, 0.05, 0.2}; ///< of R, TT, TRT
    std::array<double, 3> scale{0.1, 0.05, 0.2};
    double cuticleAngle = 0.5;
    double ior = 1.55;
    glm::dvec3 absorption{0.0};
    std::array<glm::dvec3, 3> tints{glm::dvec3(1.0), glm::dvec3(1.0), glm::dvec3(1.0)};
    glm::dvec3 tangent{1.0, 0.0, 0.0}; ///< unit
    glm::dvec3 normal{0.0, 0.0, 1.0};  ///< unit, across the tangent, on the viewer's side
    glm::dvec3 wo{0.0, 0.0, 1.0};      ///< unit

    /// Variances and scales by Chiang et al. 2016, eqs. 7 and 8, as node chiang_hair_roughness.
    void SetRoughness(double longitudinal, double azimuthal) {
        const double x = longitudinal;
        const double y = azimuthal;
        const double v = std::pow(0.726 * x + 0.812 * x * x + 3.7 * std::pow(x, 20.0), 2.0);
        const double s = 0.265 * y + 1.194 * y * y + 5.372 * std::pow(y, 22.0);
        variance = {v, v / 4.0, v * 4.0};
        scale = {s, s, s};
    }
    /// Sets the viewer by its inclination, the normal by the offset of the hit (-1 to 1).
    void SetView(double theta, double h) {
        wo = {std::sin(theta), 0.0, std::cos(theta)};
        normal = {0.0, h, std::sqrt(1.0 - h * h)};
    }
    std::vector<float> Pack() const {
        std::vector<float> packed;
        const auto add = [&](const glm::dvec3& v) {
            packed.insert(packed.end(), {float(v.x), float(v.y), float(v.z)});
        };
        add({variance[0], variance[1], variance[2]});
        add({scale[0], scale[1], scale[2]});
        add({cuticleAngle, ior, 0.0});
        for (const glm::dvec3& v :
             {absorption, tints[0], tints[1], tints[2], tangent, normal, wo}) {
            add(v);
        }
        return packed;
    }
};

constexpr const char* kUnpackHair = R"(
#include "shading/hair.clh"
HdsHair unpackHair(global const float* p) {
    float4 values[HDS_NUM_LAYERED_INPUTS];
    for (uint i = 0; i < HDS_NUM_LAYERED_INPUTS; ++i) values[i] = (float4)(0.0f);
    hair_defaults(values);
    values[HDS_INPUT_OPACITY].x = 1.0f;
    values[HDS_INPUT_HAIR].x = 1.0f;
    values[HDS_INPUT_HAIR_VARIANCE].xyz = vload3(0, p);
    values[HDS_INPUT_HAIR_SCALE].xyz = vload3(1, p);
    values[HDS_INPUT_HAIR_CUTICLE_ANGLE].x = p[6];
    values[HDS_INPUT_IOR].x = p[7];
    values[HDS_INPUT_HAIR_ABSORPTION].xyz = vload3(3, p);
    values[HDS_INPUT_HAIR_TINT_R].xyz = vload3(4, p);
    values[HDS_INPUT_HAIR_TINT_TT].xyz = vload3(5, p);
    values[HDS_INPUT_HAIR_TINT_TRT].xyz = vload3(6, p);
    HdsHair s;
    hair_setup(&s, values, vload3(9, p), vload3(8, p), vload3(7, p), HDS_HAIR_ROUND, (float3)(0.0f),
               0.0f);
    return s;
}
)";

/// What a fibre scatters from wi to the viewer, by solid angle.
class HairReference {
public:
    explicit HairReference(const HairParameters& p) : _p(p), _thetaO(Inclination(p.wo)) {
        const glm::dvec3 ahead = Across(p.wo);
        const double h = -glm::dot(p.normal, glm::cross(p.tangent, ahead));
        const double gammaO = std::asin(std::clamp(h, -1.0, 1.0));
        // Bravais' index: refraction in the plane across the fibre.
        const double index =
            std::sqrt(p.ior * p.ior - std::pow(std::sin(_thetaO), 2.0)) / std::cos(_thetaO);
        const double gammaT = std::asin(h / index);
        const double thetaT = std::asin(std::sin(_thetaO) / p.ior);
        const double f = Fresnel(std::cos(_thetaO) * std::cos(gammaO));
        for (int k = 0; k < 3; ++k) {
            const double left =
                std::exp(-p.absorption[k] * 2.0 * std::cos(gammaT) / std::cos(thetaT));
            _attenuation[0][k] = f * p.tints[0][k];
            _attenuation[1][k] = (1.0 - f) * (1.0 - f) * left * p.tints[1][k];
            _attenuation[2][k] = (1.0 - f) * (1.0 - f) * f * left * left * p.tints[2][k];
            _attenuation[3][k] = 0.0;
            double term = (1.0 - f) * (1.0 - f) * f * f * std::pow(left, 3.0);
            for (int n = 3; n < 100000 && term > 1e-12; ++n, term *= f * left) {
                _attenuation[3][k] += term * p.tints[2][k];
            }
        }
        for (int lobe = 0; lobe < 3; ++lobe) {
            _centre[lobe] = 2.0 * lobe * gammaT - 2.0 * gammaO + lobe * kPi;
        }
    }

    glm::dvec3 Evaluate(const glm::dvec3& wi) const {
        const glm::dvec3 a = Across(_p.wo);
        const glm::dvec3 b = Across(wi);
        const double phi = std::atan2(glm::dot(_p.tangent, glm::cross(a, b)), glm::dot(a, b));
        const double alpha = kPi * (_p.cuticleAngle - 0.5);
        const double turns[4] = {2.0 * alpha, -alpha, -4.0 * alpha, 0.0};
        glm::dvec3 sum(0.0);
        for (int lobe = 0; lobe < 4; ++lobe) {
            const double v = std::clamp(_p.variance[std::min(lobe, 2)], 0.001, 1.0);
            const double around = lobe == 3 ? 0.5 / kPi : Logistic(phi, lobe);
            sum += Longitudinal(Inclination(wi), _thetaO + turns[lobe], v) * around *
                   _attenuation[lobe];
        }
        return sum;
    }
    const glm::dvec3& Attenuation(int lobe) const { return _attenuation[lobe]; }

private:
    static constexpr double kPi = 3.141592653589793;

    double Inclination(const glm::dvec3& d) const {
        return std::asin(std::clamp(glm::dot(d, _p.tangent), -1.0, 1.0));
    }
    glm::dvec3 Across(const glm::dvec3& d) const {
        return glm::normalize(d - glm::dot(d, _p.tangent) * _p.tangent);
    }
    double Fresnel(double cosI) const {
        const double sinT = std::sqrt(1.0 - cosI * cosI) / _p.ior;
        const double cosT = std::sqrt(1.0 - sinT * sinT);
        const double parallel = (_p.ior * cosI - cosT) / (_p.ior * cosI + cosT);
        const double perpendicular = (cosI - _p.ior * cosT) / (cosI + _p.ior * cosT);
        return 0.5 * (parallel * parallel + perpendicular * perpendicular);
    }
    /// d'Eon et al. 2011, eq. 7.
    static double Longitudinal(double thetaI, double thetaO, double v) {
        const double argument = std::cos(thetaI) * std::abs(std::cos(thetaO)) / v;
        return std::exp(-std::sin(thetaI) * std::sin(thetaO) / v) *
               std::cyl_bessel_i(0.0, argument) / (2.0 * v * std::sinh(1.0 / v));
    }
    double Logistic(double phi, int lobe) const {
        const double s = std::sqrt(kPi / 8.0) * std::clamp(_p.scale[std::size_t(lobe)], 0.001, 1.0);
        const auto distribution = [&](double x) { return 1.0 / (1.0 + std::exp(-x / s)); };
        double x = phi - _centre[lobe];
        while (x > kPi) {
            x -= 2.0 * kPi;
        }
        while (x < -kPi) {
            x += 2.0 * kPi;
        }
        const double d = distribution(x);
        return d * (1.0 - d) / s / (distribution(kPi) - distribution(-kPi));
    }

    HairParameters _p;
    double _thetaO;
    std::array<glm::dvec3, 4> _attenuation{};
    std::array<double, 3> _centre{};
};

} // namespace hds::test
