// SPDX-License-Identifier: Apache-2.0
// Lobes of layered surfaces in double precision, written from the papers and apart from the
// kernels: angles and closed forms where those have polynomials, quadrature where those have fits
// or tables.
#pragma once

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>

namespace hds::test::reference {

constexpr double kPi = 3.14159265358979323846;

/// Fresnel's equations for the two polarisations, averaged. \param eta index behind the surface,
/// relative to that before
inline double Dielectric(double cosine, double eta) {
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine)) / eta; // Snell
    if (sine >= 1.0) {
        return 1.0;
    }
    const double within = std::sqrt(1.0 - sine * sine);
    const double s = (cosine - eta * within) / (cosine + eta * within);
    const double p = (within - eta * cosine) / (within + eta * cosine);
    return 0.5 * (s * s + p * p);
}

/// Kutz, Hasan and Edmondson 2021, "Novel aspects of the Adobe Standard Material", F82 by a tint:
/// Lazanyi and Szirmay-Kalos' term a cos (1 - cos)^6, with a so that at cos 1/7 the tint is left.
inline double Metal(double color, double tint, double cosine) {
    const auto schlick = [&](double c) { return color + (1.0 - color) * std::pow(1.0 - c, 5.0); };
    const auto lazanyi = [](double c) { return c * std::pow(1.0 - c, 6.0); };
    const double a = schlick(1.0 / 7.0) * (1.0 - tint) / lazanyi(1.0 / 7.0);
    return std::max(0.0, schlick(cosine) - a * lazanyi(cosine));
}

/// Schlick's term between two colours with any exponent, from which Lazanyi and Szirmay-Kalos' term
/// takes so much that at cos 1/7 the tint is left (Hoffman 2023, "Generalization of Adobe's Fresnel
/// Model", equations 3 to 5; MaterialX 1.39, generalized_schlick_bsdf).
inline double Schlick(double color, double grazing, double tint, double exponent, double cosine) {
    const auto mixed = [&](double c) {
        const double part = std::pow(1.0 - c, exponent);
        return (1.0 - part) * color + part * grazing;
    };
    const auto lazanyi = [](double c) { return c * std::pow(1.0 - c, 6.0); };
    const double a = mixed(1.0 / 7.0) * (1.0 - tint) / lazanyi(1.0 / 7.0);
    return std::max(0.0, mixed(cosine) - a * lazanyi(cosine));
}

/// Index and extinction of a metal by its reflectance at normal incidence and the tint of its edge
/// (Gulbrandsen 2014, "Artist Friendly Metallic Fresnel", equations 1 to 3, solved for k).
inline std::complex<double> ConductorIndex(double color, double tint) {
    const double root = std::sqrt(color);
    const double n =
        tint * (1.0 - color) / (1.0 + color) + (1.0 - tint) * (1.0 + root) / (1.0 - root);
    // ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2) is the colour.
    const double k2 = (color * std::pow(n + 1.0, 2.0) - std::pow(n - 1.0, 2.0)) / (1.0 - color);
    return {n, std::sqrt(std::max(k2, 0.0))};
}

/// Fresnel's amplitudes with a complex index, for the two polarisations, averaged.
inline double Conductor(std::complex<double> index, double cosine) {
    const std::complex<double> within =
        std::sqrt(1.0 - (1.0 - cosine * cosine) / (index * index)); // Snell
    const std::complex<double> s = (cosine - index * within) / (cosine + index * within);
    const std::complex<double> p = (within - index * cosine) / (within + index * cosine);
    return 0.5 * (std::norm(s) + std::norm(p));
}

/// Trowbridge and Reitz's distribution (Walter et al. 2007, eq. 33).
inline double Ggx(const glm::dvec3& h, double alpha) {
    const double tan2 = (1.0 - h.z * h.z) / (h.z * h.z);
    const double sum = alpha * alpha + tan2;
    return alpha * alpha / (kPi * std::pow(h.z, 4.0) * sum * sum);
}

/// Height-correlated masking and shadowing (Heitz 2014, eqs. 72 and 99), also of two sides.
inline double Smith(const glm::dvec3& wo, const glm::dvec3& wi, double alpha) {
    const auto lambda = [&](const glm::dvec3& w) {
        const double tan2 = (1.0 - w.z * w.z) / (w.z * w.z);
        return 0.5 * (std::sqrt(1.0 + alpha * alpha * tan2) - 1.0);
    };
    return 1.0 / (1.0 + lambda(wo) + lambda(wi));
}

/// f |cos(wi)| of a microfacet reflection with two alphas, along x and y (Heitz 2014, eqs. 85, 86
/// and 99).
inline double StretchedReflection(const glm::dvec3& wo, const glm::dvec3& wi, double alphaX,
                                  double alphaY, double fresnel) {
    const glm::dvec3 h = glm::normalize(wo + wi);
    const auto lambda = [&](const glm::dvec3& w) {
        const double x = alphaX * w.x / w.z;
        const double y = alphaY * w.y / w.z;
        return 0.5 * (std::sqrt(1.0 + x * x + y * y) - 1.0);
    };
    const double slopes = std::pow(h.x / h.z / alphaX, 2.0) + std::pow(h.y / h.z / alphaY, 2.0);
    const double distribution =
        1.0 / (kPi * alphaX * alphaY * std::pow(h.z, 4.0) * std::pow(1.0 + slopes, 2.0));
    return fresnel * distribution / (1.0 + lambda(wo) + lambda(wi)) / (4.0 * wo.z);
}

/// f |cos(wi)| of a microfacet reflection (Walter et al. 2007, eq. 20).
inline double Reflection(const glm::dvec3& wo, const glm::dvec3& wi, double alpha, double fresnel) {
    const glm::dvec3 h = glm::normalize(wo + wi);
    return fresnel * Ggx(h, alpha) * Smith(wo, wi, alpha) / (4.0 * wo.z);
}

/// f |cos(wi)| of a microfacet refraction, without the squared index of radiance (Walter et al.
/// 2007, eq. 21, with wo and wi exchanged, which leaves that factor out). \param eta index where wi
/// is relative to that where wo is
inline double Refraction(const glm::dvec3& wo, const glm::dvec3& wi, double alpha, double eta) {
    glm::dvec3 h = -(wo + eta * wi);
    h = glm::normalize(h.z < 0.0 ? -h : h);
    const double o = glm::dot(wo, h);
    const double i = glm::dot(wi, h);
    const double root = o + eta * i;
    return (1.0 - Dielectric(o, eta)) * Ggx(h, alpha) * Smith(wo, wi, alpha) * std::abs(o * i) *
           eta * eta / (std::abs(wo.z) * root * root);
}

/// Albedo of a microfacet reflection: over normals, whose slopes are those of the distribution.
inline double ReflectionAlbedo(double cosine, double alpha,
                               const std::function<double(double)>& fresnel) {
    constexpr int kSide = 400;
    const glm::dvec3 wo{std::sqrt(1.0 - cosine * cosine), 0.0, cosine};
    double sum = 0.0;
    for (int k = 0; k < kSide; ++k) {
        const double u = (k + 0.5) / kSide;
        const double tan2 = alpha * alpha * u / (1.0 - u);
        const double hz = 1.0 / std::sqrt(1.0 + tan2);
        for (int j = 0; j < kSide; ++j) {
            const double phi = kPi * (j + 0.5) / kSide; // the other half is the mirror image
            const double sine = std::sqrt(1.0 - hz * hz);
            const glm::dvec3 h{sine * std::cos(phi), sine * std::sin(phi), hz};
            const double o = glm::dot(wo, h);
            const glm::dvec3 wi = 2.0 * o * h - wo;
            if (o > 0.0 && wi.z > 0.0) {
                sum += fresnel(o) * Smith(wo, wi, alpha) * o / (cosine * hz);
            }
        }
    }
    return sum / (kSide * kSide);
}

/// Albedo of f cos over the upper hemisphere. \param f of wo and wi
inline double Albedo(double cosine,
                     const std::function<double(const glm::dvec3&, const glm::dvec3&)>& f) {
    constexpr int kSide = 600;
    const glm::dvec3 wo{std::sqrt(1.0 - cosine * cosine), 0.0, cosine};
    double sum = 0.0;
    for (int k = 0; k < kSide; ++k) {
        const double theta = 0.5 * kPi * (k + 0.5) / kSide;
        double ring = 0.0;
        for (int j = 0; j < kSide; ++j) {
            const double phi = kPi * (j + 0.5) / kSide;
            ring += f(wo, {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                           std::cos(theta)});
        }
        sum += ring * std::cos(theta) * std::sin(theta);
    }
    return sum * 0.5 * kPi * 2.0 * kPi / (kSide * kSide);
}

/// Fujii's Oren-Nayar, white, f (Portsmouth, Kutz and Hill 2025, section 2).
inline double Fon(double roughness, const glm::dvec3& wo, const glm::dvec3& wi) {
    const double a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * kPi)) * roughness);
    const double s = glm::dot(wo, wi) - wo.z * wi.z;
    const double t = s > 0.0 ? std::max(wo.z, wi.z) : 1.0;
    return a / kPi * (1.0 + roughness * s / t);
}

/// Its directional albedo, exactly (the same paper, section 3).
inline double FonAlbedo(double roughness, double cosine) {
    const double a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * kPi)) * roughness);
    const double theta = std::acos(cosine);
    const double sine = std::sin(theta);
    const double g = sine * (theta - sine * cosine) +
                     2.0 / 3.0 * (sine / cosine * (1.0 - sine * sine * sine) - sine);
    return a * (1.0 + roughness / kPi * g);
}

/// EON, f: what Fujii's model loses comes back diffusely, tinted by further bounces.
inline double Eon(double color, double roughness, const glm::dvec3& wo, const glm::dvec3& wi) {
    const double a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * kPi)) * roughness);
    const double mean = a * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * kPi)) * roughness);
    const double bounced = color * color * mean / (1.0 - color * (1.0 - mean));
    const double missing =
        (1.0 - FonAlbedo(roughness, wo.z)) * (1.0 - FonAlbedo(roughness, wi.z)) / (1.0 - mean);
    return color * Fon(roughness, wo, wi) + bounced / kPi * missing;
}

/// Sheen, f: Conty Estevez and Kulla 2017, eq. 2, with the visibility of Neubelt and Pettineo 2013.
inline double Sheen(double roughness, const glm::dvec3& wo, const glm::dvec3& wi) {
    const glm::dvec3 h = glm::normalize(wo + wi);
    const double sine = std::sqrt(std::max(0.0, 1.0 - h.z * h.z));
    const double distribution =
        (2.0 + 1.0 / roughness) * std::pow(sine, 1.0 / roughness) / (2.0 * kPi);
    return distribution / (4.0 * (wo.z + wi.z - wo.z * wi.z));
}

/// OpenPBR's fuzz over its albedo, f |cos|: the density of a direction that the matrix M takes from
/// a cosine lobe (Zeltner, Burley and Chiang 2022), by M's inverse as MaterialX 1.39 fits it.
inline double Fuzz(double roughness, const glm::dvec3& wo, const glm::dvec3& wi) {
    const double c = wo.z;
    const double r = roughness;
    const double a = (2.58126 * c + 0.813703 * r) * r / (1.0 + 0.310327 * c * c + 2.60994 * c * r);
    const double b = std::sqrt(1.0 - c) * (r - 1.0) * r * r * r /
                     (0.0000254053 + 1.71228 * c - 1.71506 * c * r + 1.34174 * r * r);
    const double phi = std::atan2(wo.y, wo.x);
    const glm::dvec3 turned(std::cos(phi) * wi.x + std::sin(phi) * wi.y,
                            std::cos(phi) * wi.y - std::sin(phi) * wi.x, wi.z);
    const glm::dmat3 inverse(glm::dvec3(a, 0.0, 0.0), glm::dvec3(0.0, a, 0.0),
                             glm::dvec3(b, 0.0, 1.0)); // columns
    const glm::dvec3 original = inverse * turned;
    const double length = glm::length(original);
    return original.z / length / kPi * glm::determinant(inverse) / (length * length * length);
}

/// Its directional albedo, by MaterialX's fit.
inline double FuzzAlbedo(double c, double r) {
    const double s = r * (0.0206607 + 1.58491 * r) / (0.0379424 + r * (1.32227 + r));
    const double m =
        r * (-0.193854 + r * (-1.14885 + r * (1.7932 - 0.95943 * r * r))) / (0.046391 + r);
    const double o =
        r * (0.000654023 + (-0.0207818 + 0.119681 * r) * r) / (1.26264 + r * (-1.92021 + r));
    const double x = (c - m) / s;
    return std::exp(-0.5 * x * x) / (s * std::sqrt(2.0 * kPi)) + o;
}

} // namespace hds::test::reference
