// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/settingsBridge.h"

#include "hdStream/session/memorySize.h"
#include "hdStream/session/session.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/base/tf/stringUtils.h>
#include <pxr/base/vt/types.h>
#include <pxr/imaging/hd/tokens.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

const std::string kNamespace = "hdstream:";

/// The double that a float was written as: 0.1f is 0.1, not 0.100000001490116.
double AsWritten(float value) {
    char text[64];
    const std::to_chars_result end = std::to_chars(text, text + sizeof(text), value);
    double result = static_cast<double>(value);
    std::from_chars(text, end.ptr, result);
    return result;
}

template <typename Array>
std::vector<std::string> StringsFrom(const Array& array) {
    return std::vector<std::string>(array.begin(), array.end());
}

/// Whole numbers of any width; none for other types.
std::optional<std::int64_t> IntegerFrom(const VtValue& value) {
    if (!value.IsHolding<bool>() && value.CanCast<std::int64_t>() && !value.IsHolding<double>() &&
        !value.IsHolding<float>()) {
        const VtValue cast = VtValue::Cast<std::int64_t>(value);
        if (!cast.IsEmpty()) {
            return cast.UncheckedGet<std::int64_t>();
        }
    }
    return {};
}

std::optional<hds::SettingValue> ValueFrom(const VtValue& value, hds::SettingKind kind) {
    if (value.IsHolding<bool>()) {
        return value.UncheckedGet<bool>();
    }
    if (value.IsHolding<float>()) {
        return AsWritten(value.UncheckedGet<float>());
    }
    if (value.IsHolding<double>()) {
        return value.UncheckedGet<double>();
    }
    if (value.IsHolding<std::string>()) {
        return value.UncheckedGet<std::string>();
    }
    if (value.IsHolding<TfToken>()) {
        return value.UncheckedGet<TfToken>().GetString();
    }
    if (value.IsHolding<VtStringArray>()) {
        return StringsFrom(value.UncheckedGet<VtStringArray>());
    }
    if (value.IsHolding<VtTokenArray>()) {
        return StringsFrom(value.UncheckedGet<VtTokenArray>());
    }
    if (const std::optional<std::int64_t> integer = IntegerFrom(value)) {
        if (kind == hds::SettingKind::Bool) { // user interfaces keep switches as 0 and 1
            return *integer != 0;
        }
        return *integer;
    }
    return {};
}

/// User interfaces know bool, int, float and string.
VtValue VtFrom(const hds::SettingValue& value) {
    struct Visitor {
        VtValue operator()(bool v) const { return VtValue(v); }
        VtValue operator()(std::int64_t v) const {
            const bool fits =
                v >= std::numeric_limits<int>::min() && v <= std::numeric_limits<int>::max();
            return fits ? VtValue(static_cast<int>(v)) : VtValue(v);
        }
        VtValue operator()(double v) const { return VtValue(static_cast<float>(v)); }
        VtValue operator()(const std::string& v) const { return VtValue(v); }
        VtValue operator()(const std::vector<std::string>& v) const {
            return VtValue(VtStringArray(v.begin(), v.end()));
        }
    };
    return std::visit(Visitor{}, value);
}

/// Sets one value. \return what is wrong, or an empty text. Former spellings are set with a note,
/// unless it is among `told`.
std::string Apply(hds::Settings* settings, const std::string& name, const VtValue& value,
                  hds::SettingValue* applied, std::set<std::string>* told) {
    const hds::SettingInfo* info = hds::FindSetting(name);
    if (!info || !info->IsUserSetting()) {
        return name + " is no render setting of Stream";
    }
    std::optional<hds::SettingValue> converted = ValueFrom(value, info->kind);
    if (!converted) {
        return name + ": a value of type " + value.GetTypeName() + " is of no use";
    }
    try {
        if (const auto* text = std::get_if<std::string>(&*converted);
            text &&
            info->kind == hds::SettingKind::Bytes) { // no integer of a user interface holds it
            converted = static_cast<std::int64_t>(hds::ParseBytes(*text));
        }
        const std::string note = hds::SetSetting(settings, name, *converted);
        if (!note.empty() && told->insert(note).second) {
            TF_WARN("%s", note.c_str());
        }
    } catch (const hds::Error& error) {
        return error.what();
    }
    *applied = hds::GetSetting(*settings, name);
    return {};
}

} // namespace

HdRenderSettingDescriptorList HdStreamSettingsBridge::Descriptors() {
    HdRenderSettingDescriptorList descriptors;
    const hds::Settings defaults;
    for (const hds::SettingInfo& info : hds::SettingTable()) {
        if (info.IsUserSetting()) {
            // Descriptors have no place for it but the name; the table has the advanced ones last.
            const std::string label = info.label + (info.IsAdvanced() ? " (advanced)" : "");
            descriptors.push_back(
                {label, TfToken(info.name), VtFrom(hds::GetSetting(defaults, info.name))});
        }
    }
    return descriptors;
}

std::string HdStreamSettingsBridge::NameOf(const TfToken& key) {
    if (key == HdRenderSettingsTokens->convergedSamplesPerPixel) {
        return "samples";
    }
    if (key == HdRenderSettingsTokens->convergedVariance) {
        return "noise";
    }
    if (key == HdRenderSettingsTokens->domeLightCameraVisibility) {
        return "domeVisible";
    }
    const std::string& text = key.GetString();
    const std::string name =
        TfStringStartsWith(text, kNamespace) ? text.substr(kNamespace.size()) : text;
    const hds::SettingInfo* info = hds::FindSetting(name);
    return info && info->IsUserSetting() ? name : std::string();
}

bool HdStreamSettingsBridge::Set(const TfToken& key, const VtValue& value, std::string* problem) {
    const std::string name = NameOf(key);
    VtValue wanted = value;
    if (key == HdRenderSettingsTokens->convergedVariance && value.CanCast<double>()) {
        // The core stops at an error, which is the root of a variance.
        wanted.Cast<double>();
        wanted = VtValue(std::sqrt(std::max(wanted.GetWithDefault(0.0), 0.0)));
    }
    hds::Settings settings = Compose({}, nullptr);
    hds::SettingValue applied;
    *problem = Apply(&settings, name, wanted, &applied, &_toldNotes);
    if (!problem->empty()) {
        return false;
    }
    // Hosts hand all defaults back; only what differs is a choice that outweighs the scene's.
    if (IsSet(name) || applied != hds::GetSetting(hds::Settings(), name)) {
        _values[name] = applied;
    }
    return true;
}

VtValue HdStreamSettingsBridge::Get(const std::string& name) const {
    const auto found = _values.find(name);
    return VtFrom(found != _values.end() ? found->second : hds::GetSetting(hds::Settings(), name));
}

hds::Settings HdStreamSettingsBridge::Compose(const VtDictionary& sceneSettings,
                                              std::vector<std::string>* problems) {
    hds::Settings settings;
    for (const auto& [key, value] : sceneSettings) {
        if (!TfStringStartsWith(key, kNamespace)) {
            continue;
        }
        hds::SettingValue applied;
        std::string problem =
            Apply(&settings, key.substr(kNamespace.size()), value, &applied, &_toldNotes);
        if (!problem.empty() && problems) {
            problems->push_back(std::move(problem));
        }
    }
    for (const auto& [name, value] : _values) {
        hds::SetSetting(&settings, name, value);
    }
    return settings;
}

PXR_NAMESPACE_CLOSE_SCOPE
