// SPDX-License-Identifier: Apache-2.0
// A coefficient of a volume's material: a sum of products of fields. Explained in docs/volumes.md.
#pragma once

#include <glm/vec3.hpp>

#include <string>
#include <vector>

namespace hds {

/// A colour times fields of a volume, and patterns (volumePatterns.h).
struct FieldProduct {
    std::vector<std::string> fields; ///< names in order; one that is squared is there twice
    glm::vec3 color{0.0F};
};

/// A sum of products, which differ in their fields. Those that are 0 are left out.
class VolumeCoefficient {
public:
    /// The constant 0.
    VolumeCoefficient() = default;
    explicit VolumeCoefficient(glm::vec3 constant);
    explicit VolumeCoefficient(const std::string& field);

    const std::vector<FieldProduct>& Products() const { return _products; }
    /// Where all fields are 1.
    glm::vec3 AtOne() const;
    /// Whether it has fields or patterns; else it is constant.
    bool HasFields() const;
    /// \return whether each product has just the field `name`.
    bool IsMultipleOf(const std::string& name) const;

    VolumeCoefficient operator+(const VolumeCoefficient& other) const;
    VolumeCoefficient operator-(const VolumeCoefficient& other) const;
    VolumeCoefficient operator*(const VolumeCoefficient& other) const;
    VolumeCoefficient operator/(glm::vec3 constant) const;

private:
    void Add(const FieldProduct& product);

    std::vector<FieldProduct> _products;
};

} // namespace hds
