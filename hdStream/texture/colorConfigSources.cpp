// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/colorConfigSources.h"

#include "hdStream/base/hash.h"
#include "hdStream/persist/fileIdentity.h"

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <system_error>

namespace OCIO = OCIO_NAMESPACE;

namespace hds {

namespace {

bool IsFile(const std::string& name) {
    std::error_code ignored;
    return std::filesystem::is_regular_file(name, ignored);
}

/// Collects what all transforms of a configuration name, in its order.
class Walk {
public:
    Walk(const OCIO::ConstConfigRcPtr& config, ColorConfigSources* sources)
        : _context(config->getCurrentContext()), _sources(sources) {}

    void Add(const OCIO::ConstTransformRcPtr& transform) {
        if (const auto group = OCIO::DynamicPtrCast<const OCIO::GroupTransform>(transform)) {
            for (int i = 0; i < group->getNumTransforms(); ++i) {
                Add(group->getTransform(i));
            }
        } else if (const auto file = OCIO::DynamicPtrCast<const OCIO::FileTransform>(transform)) {
            AddFile(file->getSrc());
            AddWords({file->getCCCId()});
        } else if (const auto space =
                       OCIO::DynamicPtrCast<const OCIO::ColorSpaceTransform>(transform)) {
            AddWords({space->getSrc(), space->getDst()});
        } else if (const auto look = OCIO::DynamicPtrCast<const OCIO::LookTransform>(transform)) {
            AddWords({look->getSrc(), look->getDst(), look->getLooks()});
        } else if (const auto view =
                       OCIO::DynamicPtrCast<const OCIO::DisplayViewTransform>(transform)) {
            AddWords({view->getSrc(), view->getDisplay(), view->getView()});
        }
    }

private:
    /// A name that leads to no file is a word: what uses it fails.
    void AddFile(const char* name) {
        std::string file;
        try {
            file = _context->resolveFileLocation(name);
        } catch (const OCIO::Exception&) {
            AddWords({name});
            return;
        }
        std::vector<std::string>& files = _sources->files;
        if (std::find(files.begin(), files.end(), file) == files.end()) {
            files.push_back(file);
        }
    }

    void AddWords(std::initializer_list<const char*> words) {
        for (const char* word : words) {
            _sources->words.emplace_back(_context->resolveStringVar(word));
        }
    }

    OCIO::ConstContextRcPtr _context;
    ColorConfigSources* _sources;
};

} // namespace

ColorConfigSources SourcesOf(const OCIO::ConstConfigRcPtr& config, const std::string& name) {
    ColorConfigSources sources;
    (IsFile(name) ? sources.files : sources.words).push_back(name);
    Walk walk(config, &sources);
    const auto kAll = OCIO::SEARCH_REFERENCE_SPACE_ALL;
    for (int i = 0; i < config->getNumColorSpaces(kAll, OCIO::COLORSPACE_ALL); ++i) {
        const OCIO::ConstColorSpaceRcPtr space =
            config->getColorSpace(config->getColorSpaceNameByIndex(kAll, OCIO::COLORSPACE_ALL, i));
        walk.Add(space->getTransform(OCIO::COLORSPACE_DIR_TO_REFERENCE));
        walk.Add(space->getTransform(OCIO::COLORSPACE_DIR_FROM_REFERENCE));
    }
    for (int i = 0; i < config->getNumViewTransforms(); ++i) {
        const OCIO::ConstViewTransformRcPtr view =
            config->getViewTransform(config->getViewTransformNameByIndex(i));
        walk.Add(view->getTransform(OCIO::VIEWTRANSFORM_DIR_TO_REFERENCE));
        walk.Add(view->getTransform(OCIO::VIEWTRANSFORM_DIR_FROM_REFERENCE));
    }
    for (int i = 0; i < config->getNumLooks(); ++i) {
        const OCIO::ConstLookRcPtr look = config->getLook(config->getLookNameByIndex(i));
        walk.Add(look->getTransform());
        walk.Add(look->getInverseTransform());
    }
    for (int i = 0; i < config->getNumNamedTransforms(OCIO::NAMEDTRANSFORM_ALL); ++i) {
        const OCIO::ConstNamedTransformRcPtr named = config->getNamedTransform(
            config->getNamedTransformNameByIndex(OCIO::NAMEDTRANSFORM_ALL, i));
        walk.Add(named->getTransform(OCIO::TRANSFORM_DIR_FORWARD));
        walk.Add(named->getTransform(OCIO::TRANSFORM_DIR_INVERSE));
    }
    return sources;
}

std::string IdentityOf(const ColorConfigSources& sources) {
    Hasher hasher;
    hasher.Append(static_cast<std::uint64_t>(sources.words.size()));
    for (const std::string& word : sources.words) {
        hasher.Append(word);
    }
    for (const std::string& file : sources.files) {
        if (!AppendFileIdentity(&hasher, file, 0, 0)) {
            hasher.Append(file);
        }
    }
    return hasher.Hex();
}

} // namespace hds
