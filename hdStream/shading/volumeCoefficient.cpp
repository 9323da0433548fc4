// SPDX-License-Identifier: Apache-2.0
#include "hdStream/shading/volumeCoefficient.h"

#include <algorithm>

namespace hds {

VolumeCoefficient::VolumeCoefficient(glm::vec3 constant) {
    Add({{}, constant});
}

VolumeCoefficient::VolumeCoefficient(const std::string& field) {
    Add({{field}, glm::vec3(1.0F)});
}

glm::vec3 VolumeCoefficient::AtOne() const {
    glm::vec3 sum(0.0F);
    for (const FieldProduct& product : _products) {
        sum += product.color;
    }
    return sum;
}

bool VolumeCoefficient::HasFields() const {
    return std::any_of(_products.begin(), _products.end(),
                       [](const FieldProduct& product) { return !product.fields.empty(); });
}

bool VolumeCoefficient::IsMultipleOf(const std::string& name) const {
    return std::all_of(_products.begin(), _products.end(), [&](const FieldProduct& product) {
        return product.fields.size() == 1 && product.fields[0] == name;
    });
}

VolumeCoefficient VolumeCoefficient::operator+(const VolumeCoefficient& other) const {
    VolumeCoefficient sum = *this;
    for (const FieldProduct& product : other._products) {
        sum.Add(product);
    }
    return sum;
}

VolumeCoefficient VolumeCoefficient::operator-(const VolumeCoefficient& other) const {
    return *this + VolumeCoefficient(glm::vec3(-1.0F)) * other;
}

VolumeCoefficient VolumeCoefficient::operator*(const VolumeCoefficient& other) const {
    VolumeCoefficient result;
    for (const FieldProduct& a : _products) {
        for (const FieldProduct& b : other._products) {
            FieldProduct product{a.fields, a.color * b.color};
            product.fields.insert(product.fields.end(), b.fields.begin(), b.fields.end());
            std::sort(product.fields.begin(), product.fields.end());
            result.Add(product);
        }
    }
    return result;
}

VolumeCoefficient VolumeCoefficient::operator/(glm::vec3 constant) const {
    VolumeCoefficient result;
    for (const FieldProduct& product : _products) {
        result.Add({product.fields, product.color / constant});
    }
    return result;
}

void VolumeCoefficient::Add(const FieldProduct& product) {
    const auto found =
        std::find_if(_products.begin(), _products.end(),
                     [&](const FieldProduct& mine) { return mine.fields == product.fields; });
    if (found == _products.end()) {
        if (product.color != glm::vec3(0.0F)) {
            _products.push_back(product);
        }
        return;
    }
    found->color += product.color;
    if (found->color == glm::vec3(0.0F)) {
        _products.erase(found);
    }
}

} // namespace hds
