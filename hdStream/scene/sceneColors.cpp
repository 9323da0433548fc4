// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/sceneColors.h"

#include "hdStream/base/error.h"
#include "hdStream/geometry/splatSource.h"
#include "hdStream/shading/colorInputs.h"
#include "hdStream/shading/lightUnits.h"
#include "hdStream/texture/colorConversion.h"
#include "hdStream/texture/oneLine.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace hds {

namespace {

/// USD's fallback of colours that name no space.
constexpr const char* kFallbackSpace = "lin_rec709";
constexpr const char* kSpacePrefix = "colorSpace:";
constexpr const char* kSourceSpace = "sourceColorSpace";

std::string TextOf(const MaterialNode& node, const std::string& name) {
    const auto found = node.parameters.find(name);
    const auto* text =
        found == node.parameters.end() ? nullptr : std::get_if<std::string>(&found->second);
    return text == nullptr ? std::string() : *text;
}

bool NamesSpaces(const std::vector<Primvar>& primvars) {
    return std::any_of(primvars.begin(), primvars.end(),
                       [](const Primvar& primvar) { return !primvar.colorSpace.empty(); });
}

bool NamesSpaces(const MaterialNode& node) {
    const auto found = node.parameters.lower_bound(kSpacePrefix);
    return found != node.parameters.end() &&
           found->first.compare(0, std::char_traits<char>::length(kSpacePrefix), kSpacePrefix) == 0;
}

bool NamesSpaces(const MaterialNetwork& network) {
    return std::any_of(network.nodes.begin(), network.nodes.end(),
                       [](const MaterialNode& node) { return NamesSpaces(node); });
}

/// Images aside, which say what they are.
bool NamesSpaces(const SceneDescription& scene) {
    const auto any = [](const auto& prims, const auto& test) {
        return std::any_of(prims.begin(), prims.end(),
                           [&](const auto& entry) { return test(entry.second); });
    };
    return any(scene.geometry,
               [](const GeometryPrim& prim) {
                   return (prim.geometry && NamesSpaces(prim.geometry->primvars)) ||
                          (prim.light && !prim.light->light.colorSpace.empty());
               }) ||
           any(scene.instancers,
               [](const InstancerPrim& prim) { return NamesSpaces(prim.primvars); }) ||
           any(scene.lights,
               [](const LightPrim& prim) {
                   return !prim.light.colorSpace.empty() ||
                          std::any_of(
                              prim.filters.begin(), prim.filters.end(),
                              [](const LightFilter& filter) { return NamesSpaces(filter.node); });
               }) ||
           any(scene.materials, [](const std::shared_ptr<const MaterialNetwork>& network) {
               return network && NamesSpaces(*network);
           });
}

/// Settings of a filter that are no light although their names say colour.
bool IsColorOfFilter(const std::string& name) {
    const auto has = [&](const char* part) { return name.find(part) != std::string::npos; };
    return (has("olor") || has("tint")) && !has("aturation") && !has("ontrast") &&
           !has("osition") && !has("Knots");
}

} // namespace

/// One conversion of a scene.
class SceneColors::Pass {
public:
    Pass(SceneColors* colors, const std::string& workingSpace, Warnings& warnings)
        : _colors(*colors), _workingSpace(workingSpace), _warnings(warnings) {}

    void Run(SceneDescription* scene) {
        Copies<GeometryDescription> geometry;
        Copies<MaterialNetwork> materials;
        Copies<MeshLight> meshLights;
        for (auto& [path, prim] : scene->geometry) {
            _path = &path;
            Replace(&prim.geometry, &_colors._geometry, &geometry);
            Replace(&prim.light, &_colors._meshLights, &meshLights);
        }
        for (auto& [path, network] : scene->materials) {
            _path = &path;
            Replace(&network, &_colors._materials, &materials);
        }
        for (auto& [path, prim] : scene->instancers) {
            _path = &path;
            ConvertPrimvars(&prim.primvars);
        }
        for (auto& [path, prim] : scene->lights) {
            _path = &path;
            for (LightSample& sample : prim.samples) {
                ConvertSample(prim.light, &sample);
            }
            ConvertLight(&prim.light);
            for (LightFilter& filter : prim.filters) {
                ConvertFilter(&filter.node);
            }
        }
        _colors._geometry = std::move(geometry);
        _colors._materials = std::move(materials);
        _colors._meshLights = std::move(meshLights);
    }

private:
    /// What something shared has become before, else what it becomes now.
    template <typename T>
    void Replace(std::shared_ptr<const T>* shared, const Copies<T>* known, Copies<T>* used) {
        if (!*shared) {
            return;
        }
        const auto [entry, isNew] = used->emplace(*shared, nullptr);
        if (isNew) {
            const auto before = known->find(*shared);
            entry->second = before == known->end() ? Converted(*shared) : before->second;
        }
        *shared = entry->second;
    }

    std::shared_ptr<const GeometryDescription>
    Converted(const std::shared_ptr<const GeometryDescription>& geometry) {
        std::vector<Primvar> primvars = geometry->primvars;
        if (!ConvertPrimvars(&primvars)) {
            return geometry;
        }
        auto copy = std::make_shared<GeometryDescription>(*geometry);
        copy->primvars = std::move(primvars);
        return copy;
    }

    std::shared_ptr<const MeshLight> Converted(const std::shared_ptr<const MeshLight>& light) {
        auto copy = std::make_shared<MeshLight>(*light);
        ConvertLight(&copy->light);
        return copy;
    }

    std::shared_ptr<const MaterialNetwork>
    Converted(const std::shared_ptr<const MaterialNetwork>& network) {
        if (_workingSpace.empty() && !NamesSpaces(*network)) {
            return network;
        }
        auto copy = std::make_shared<MaterialNetwork>(*network);
        for (MaterialNode& node : copy->nodes) {
            ConvertNode(&node);
        }
        return copy;
    }

    /// \return whether some value has changed.
    bool ConvertPrimvars(std::vector<Primvar>* primvars) {
        bool hasChanged = false;
        for (Primvar& primvar : *primvars) {
            const bool isFallback =
                primvar.name == "displayColor" || primvar.name == kSplatHarmonics;
            const ColorConversion* conversion =
                primvar.numComponents < 3
                    ? nullptr
                    : Find(primvar.colorSpace, isFallback, "primvar " + primvar.name);
            if (conversion != nullptr) {
                const SharedSpan<float> held = primvar.values.Held();
                std::vector<float> values(held.begin(), held.end());
                conversion->Apply(values.data(), values.size() / primvar.numComponents,
                                  primvar.numComponents);
                primvar.values = std::move(values);
                hasChanged = true;
            }
        }
        return hasChanged;
    }

    void ConvertNode(MaterialNode* node) {
        for (auto& [name, value] : node->parameters) {
            auto* numbers = std::get_if<std::vector<float>>(&value);
            const bool isRamp = numbers != nullptr && numbers->size() % 3 == 0 &&
                                node->identifier == "arnold:ramp_rgb" && name == "color";
            if (numbers == nullptr || (!isRamp && numbers->size() != 3 && numbers->size() != 4)) {
                continue;
            }
            const ColorConversion* conversion =
                Find(TextOf(*node, kSpacePrefix + name), IsColorInput(node->identifier, name),
                     "input " + name + " of " + node->path);
            if (conversion != nullptr) {
                conversion->Apply(numbers->data(), isRamp ? numbers->size() / 3 : 1);
            }
        }
        if (!_workingSpace.empty() && IsColorImage(node->identifier)) {
            NameConversions(node);
        }
    }

    /// Images are converted to the working space as they are read.
    void NameConversions(MaterialNode* node) {
        std::vector<std::pair<std::string, std::string>> named;
        const bool isOfUsd = node->identifier.find("UsdUVTexture") != std::string::npos;
        for (const auto& [name, value] : node->parameters) {
            if (!std::holds_alternative<AssetReference>(value)) {
                continue;
            }
            std::string space = TextOf(*node, kSourceSpace);
            const bool isOfAttribute = space.empty() || space == "auto";
            if (isOfAttribute) {
                space = TextOf(*node, kSpacePrefix + name);
            }
            if (isOfUsd && space.empty()) {
                space = "auto";
            }
            if ((isOfUsd && space == "auto") || !IsDataSpace(space)) {
                named.emplace_back(isOfUsd || !isOfAttribute ? kSourceSpace : kSpacePrefix + name,
                                   JoinConversion(space, _workingSpace));
            }
        }
        for (auto& [name, conversion] : named) {
            node->parameters[name] = std::move(conversion);
        }
    }

    /// \return whether a temperature still tints the colour
    bool ConvertColor(const LightDescription& light, float temperature,
                      std::array<float, 3>* color) {
        const ColorConversion* conversion = Find(light.colorSpace, true, "its color");
        if (conversion != nullptr) {
            conversion->Apply(color->data(), 1);
        }
        const ColorConversion* ofFallback =
            light.enableColorTemperature ? Find("", true, "") : nullptr;
        if (ofFallback == nullptr) {
            return light.enableColorTemperature;
        }
        const glm::vec3 blackbody(BlackbodyRgb(static_cast<double>(temperature)));
        std::array<float, 3> rgb{blackbody.x, blackbody.y, blackbody.z};
        ofFallback->Apply(rgb.data(), 1);
        for (std::size_t i = 0; i < 3; ++i) {
            (*color)[i] *= rgb[i];
        }
        return false;
    }

    /// \param light not converted yet
    void ConvertSample(const LightDescription& light, LightSample* sample) {
        ConvertColor(light, sample->colorTemperature, &sample->color);
    }

    void ConvertLight(LightDescription* light) {
        const ColorConversion* conversion = Find(light->colorSpace, true, "its color");
        if (conversion != nullptr) {
            conversion->Apply(light->shaping.focusTint.data(), 1);
            conversion->Apply(light->shadow.color.data(), 1);
        }
        light->enableColorTemperature =
            ConvertColor(*light, light->colorTemperature, &light->color);
        NameConversion(&light->textureFile);
    }

    void ConvertFilter(MaterialNode* node) {
        for (auto& [name, value] : node->parameters) {
            if (auto* asset = std::get_if<AssetReference>(&value)) {
                NameConversion(asset);
            }
            auto* numbers = std::get_if<std::vector<float>>(&value);
            if (numbers == nullptr || numbers->size() % 3 != 0) {
                continue;
            }
            const ColorConversion* conversion =
                Find(TextOf(*node, kSpacePrefix + name), IsColorOfFilter(name),
                     "input " + name + " of " + node->path);
            if (conversion != nullptr) {
                conversion->Apply(numbers->data(), numbers->size() / 3);
            }
        }
    }

    void NameConversion(AssetReference* image) const {
        const bool isUnnamed = image->colorSpace.empty() || image->colorSpace == "auto";
        if (_workingSpace.empty() || image->authoredPath.empty() ||
            (!isUnnamed && IsDataSpace(image->colorSpace))) {
            return;
        }
        image->colorSpace =
            JoinConversion(isUnnamed ? std::string(kAutoColor) : image->colorSpace, _workingSpace);
    }

    /// The conversion of colours of a space; null: they stay as they are. \param isColor they are
    /// colours even if no space is named.
    const ColorConversion* Find(const std::string& space, bool isColor, const std::string& what) {
        std::string from = space;
        if (from.empty()) {
            if (_workingSpace.empty() || !isColor) {
                return nullptr;
            }
            from = kFallbackSpace;
        }
        if (IsDataSpace(from)) {
            return nullptr;
        }
        auto known = _conversions.find(from);
        if (known == _conversions.end()) {
            known = _conversions.emplace(from, nullptr).first;
            try {
                known->second = std::make_unique<ColorConversion>(from, _workingSpace);
            } catch (const std::exception& failure) {
                _errors[from] = OneLine(failure.what());
            }
        }
        if (!known->second) {
            _warnings.Add(*_path, what + ": colour space '" + from + "' cannot be used (" +
                                      _errors[from] + "); its numbers are taken as they are");
            return nullptr;
        }
        return known->second->IsIdentity() ? nullptr : known->second.get();
    }

    SceneColors& _colors;
    const std::string& _workingSpace;
    Warnings& _warnings;
    const std::string* _path = nullptr; ///< of the prim that is being converted
    std::map<std::string, std::unique_ptr<ColorConversion>> _conversions; ///< by source
    std::map<std::string, std::string> _errors;
};

const SceneDescription& SceneColors::Convert(const SceneDescription& scene,
                                             const std::string& workingSpace, Warnings& warnings) {
    if (workingSpace.empty() && !NamesSpaces(scene)) {
        *this = SceneColors();
        return scene;
    }
    const std::string key = workingSpace + '\n' + ColorConfigIdentity();
    if (key != _key) {
        *this = SceneColors();
        _key = key;
    }
    _converted = scene;
    Pass(this, workingSpace, warnings).Run(&_converted);
    return _converted;
}

std::optional<std::array<float, 9>> WorkingFromRec709(const std::string& workingSpace) {
    if (workingSpace.empty()) {
        return std::nullopt;
    }
    const ColorConversion conversion(kFallbackSpace, workingSpace);
    if (conversion.IsIdentity()) {
        return std::nullopt;
    }
    std::array<float, 9> columns{1, 0, 0, 0, 1, 0, 0, 0, 1};
    conversion.Apply(columns.data(), 3);
    return std::array<float, 9>{columns[0], columns[3], columns[6], columns[1], columns[4],
                                columns[7], columns[2], columns[5], columns[8]};
}

} // namespace hds
