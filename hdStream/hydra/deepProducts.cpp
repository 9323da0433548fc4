// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/deepProducts.h"

#include "hdStream/session/imageMetadata.h"

#include <pxr/base/tf/stringUtils.h>
#include <pxr/base/vt/array.h>
#include <pxr/imaging/hd/aov.h>

#include <algorithm>
#include <set>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

using Entries = HdAovSettingsMap;

const std::string kHeaderPrefix = "driver:parameters:OpenEXR:";

/// A string, token or number as text; empty: there is none.
std::string TextOf(const VtValue& value) {
    if (value.IsHolding<TfToken>()) {
        return value.UncheckedGet<TfToken>().GetString();
    }
    return value.IsHolding<std::string>() ? value.UncheckedGet<std::string>() : TfStringify(value);
}

std::string TextOf(const Entries& entries, const char* name) {
    const auto found = entries.find(TfToken(name));
    return found == entries.end() ? std::string() : TextOf(found->second);
}

/// Whether a render var is a deep picture's colour, by one of the names that the command line
/// takes (renderSettings.py).
bool IsColor(const std::string& source) {
    static const std::set<std::string> names{"color", "Ci", "rgba", "RGBA", "beauty"};
    return names.count(source) > 0;
}

bool IsHalf(const std::string& type) {
    return TfStringStartsWith(type, "half") ||
           (TfStringStartsWith(type, "color") && TfStringEndsWith(type, "h"));
}

/// Whether the colour of a product is asked for as halves.
bool HasHalfColor(const Entries& product) {
    const auto vars = product.find(TfToken("orderedVars"));
    if (vars == product.end() || !vars->second.IsHolding<VtArray<Entries>>()) {
        return false;
    }
    const VtArray<Entries>& all = vars->second.UncheckedGet<VtArray<Entries>>();
    return std::any_of(all.begin(), all.end(), [](const Entries& var) {
        return IsColor(TextOf(var, "sourceName")) && IsHalf(TextOf(var, "dataType"));
    });
}

std::map<std::string, std::string> HeaderTexts(const Entries& product) {
    std::map<std::string, std::string> texts;
    for (const auto& [key, value] : product) {
        const std::string& name = key.GetString();
        if (name == "driver:parameters:artist") {
            texts["Artist"] = TextOf(value);
        } else if (name == "driver:parameters:comment") {
            texts["ImageDescription"] = TextOf(value); // OpenImageIO's name of `comments`
        } else if (TfStringStartsWith(name, kHeaderPrefix) &&
                   name != kHeaderPrefix + "dwaCompressionLevel" &&
                   name != kHeaderPrefix + "tileSize") {
            texts[name.substr(kHeaderPrefix.size())] = TextOf(value);
        }
    }
    return texts;
}

} // namespace

std::vector<HdStreamDeepProduct> HdStreamDeepProducts(const VtValue& value,
                                                      std::vector<std::string>* problems) {
    std::vector<HdStreamDeepProduct> products;
    if (!value.IsHolding<VtArray<Entries>>()) {
        return products;
    }
    for (const Entries& entries : value.UncheckedGet<VtArray<Entries>>()) {
        const std::string type = TextOf(entries, "productType");
        const std::string file = TextOf(entries, "productName");
        if (type != "deepRaster") {
            problems->push_back("product '" + file + "' of type '" + type +
                                "' is not supported; left out");
        } else if (file.empty()) {
            problems->push_back("a deep product has no productName; left out");
        } else {
            products.push_back({file, HasHalfColor(entries), HeaderTexts(entries)});
        }
    }
    return products;
}

void HdStreamWriteDeepProducts(const std::vector<HdStreamDeepProduct>& products,
                               const hds::Settings& settings, const hds::Session& session) {
    const auto camera = session.Scene().cameras.find(settings.camera);
    hds::ImageMetadata metadata = camera != session.Scene().cameras.end() // the render has had it
                                      ? hds::MakeImageMetadata(settings, camera->second)
                                      : hds::ImageMetadata();
    const hds::DeepImage image = session.Deep();
    for (const HdStreamDeepProduct& product : products) {
        metadata.texts = product.texts;
        hds::WriteDeepImage(product.file, image, product.isHalf, metadata);
    }
}

PXR_NAMESPACE_CLOSE_SCOPE
