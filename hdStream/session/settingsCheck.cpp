// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/settingsCheck.h"

#include "hdStream/base/error.h"
#include "hdStream/scene/cameraNumbers.h"
#include "hdStream/session/memorySize.h"
#include "hdStream/session/settingsTable.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace hds {

namespace {

/// Largest coordinate of a display window, in pixels.
constexpr double kMaxWindow = 1e8;

/// The index of a checked choice: the tables' order is the enumerations'.
template <typename Enum>
Enum EnumOf(const std::string& setting, const std::string& value) {
    const std::vector<std::string>& choices = FindSetting(setting)->choices;
    const auto found = std::find(choices.begin(), choices.end(), value);
    HDS_VERIFY(found != choices.end(), setting + " " + value);
    return static_cast<Enum>(found - choices.begin());
}

static_assert(static_cast<int>(ConformPolicy::AdjustPixelAspectRatio) == 4, "order of the choices");
static_assert(static_cast<int>(Subdivision::Cage) == 2, "order of the choices");
static_assert(static_cast<int>(TraversalForm::Scalar) == 3, "order of the choices");
static_assert(static_cast<int>(ResidencyMode::Stream) == 2, "order of the choices");
static_assert(static_cast<int>(Eviction::Flush) == 1, "order of the choices");
// CullStyle begins with DontCare, which is no choice.
static_assert(static_cast<int>(CullStyle::Nothing) == 1, "order of the choices");

/// Of a checked text; empty is the default: both 0.
MemorySize MemoryOf(const std::string& text) {
    return text.empty() ? MemorySize() : ParseMemorySize(text);
}

} // namespace

bool IsWorkingSpace(const std::string& name) {
    return IsColorSpace(name) && !IsDataSpace(name);
}

void CheckSettings(const Settings& settings) {
    for (const SettingInfo& info : SettingTable()) {
        CheckSettingValue(info, GetSetting(settings, info.name));
    }
    const bool hasWindow = settings.displayWindow != std::array<double, 4>{};
    if (hasWindow && !(settings.displayWindow[2] > settings.displayWindow[0] &&
                       settings.displayWindow[3] > settings.displayWindow[1])) {
        throw Error("displayWindow: it is empty", ErrorKind::Usage);
    }
    const auto checkCorners = [](const char* name, const std::array<double, 4>& window) {
        for (const double corner : window) {
            if (!(std::abs(corner) <= kMaxWindow)) {
                throw Error(std::string(name) + ": " + std::to_string(corner) + " is out of range",
                            ErrorKind::Usage);
            }
        }
    };
    checkCorners("displayWindow", settings.displayWindow);
    checkCorners("uncroppedWindow", settings.uncroppedWindow);
    CheckAovs(settings.aovs);
    if (!settings.workingSpace.empty() && !IsWorkingSpace(settings.workingSpace)) {
        throw Error("--workingSpace: '" + settings.workingSpace +
                        "' is no colour space of the OpenColorIO configuration",
                    ErrorKind::Usage);
    }
    if (settings.residency == "mapped" && settings.noCache) {
        throw Error("--residency mapped: needs the persistent cache, which --noCache switches off",
                    ErrorKind::Usage);
    }
}

RenderOptions MakeRenderOptions(const Settings& settings, const CameraPrim& camera) {
    RenderOptions options;
    options.camera = camera;
    MendCamera(&options.camera); // Session::Render says what is wrong
    options.camera.exposureScale =
        std::min(options.camera.exposureScale * static_cast<float>(std::exp2(settings.exposure)),
                 std::numeric_limits<float>::max());
    if (settings.motionBlur == "on" && camera.shutter.IsOpen()) {
        options.shutter = camera.shutter;
    }
    options.imageWidth = settings.imageWidth;
    options.imageHeight = settings.imageHeight;
    options.pixelAspectRatio = settings.pixelAspectRatio;
    options.displayWindow = settings.displayWindow;
    if (settings.displayWindow == std::array<double, 4>{}) {
        options.displayWindow = {0.0, 0.0, static_cast<double>(settings.imageWidth),
                                 static_cast<double>(settings.imageHeight)};
    }
    options.dataWindowMin = settings.dataWindowMin;
    options.uncroppedWindow = settings.uncroppedWindow;
    const bool isCrop = settings.uncroppedWindow != std::array<double, 4>{};
    // Counted from the display window's own corner, so that a crop has the bits of the full image
    // however the host numbers its pixels.
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const double corner = std::floor(options.displayWindow[axis]);
        options.displayWindow[axis] -= corner;
        options.displayWindow[axis + 2] -= corner;
        options.dataWindowMin[axis] -= static_cast<std::int32_t>(corner);
        options.uncroppedWindow[axis] -= isCrop ? corner : 0.0;
        options.uncroppedWindow[axis + 2] -= isCrop ? corner : 0.0;
    }
    options.conformPolicy = EnumOf<ConformPolicy>("conformPolicy", settings.conformPolicy);
    options.aovs = MakeAovLayout(settings.aovs);
    if (settings.deep) {
        DeepLimits& deep = options.deep.emplace();
        deep.tolerance = static_cast<float>(settings.deepTolerance);
        deep.mostSamples = settings.deepSamples;
        deep.farDepth = std::min(static_cast<float>(options.camera.farClip), deep.farDepth);
    }
    options.samples = settings.samples;
    options.maxDepth = settings.maxDepth;
    options.maxDiffuseDepth = settings.maxDiffuseDepth;
    options.maxGlossyDepth = settings.maxGlossyDepth;
    options.maxTransmissionDepth = settings.maxTransmissionDepth;
    options.clampDirect = settings.clampDirect;
    options.clampIndirect = settings.clampIndirect;
    options.filterGlossy = settings.filterGlossy;
    options.occlusionDistance = settings.occlusionDistance > 0.0
                                    ? static_cast<float>(settings.occlusionDistance)
                                    : std::numeric_limits<float>::infinity();
    options.smoothTerminator = settings.smoothTerminator;
    options.glassShadows = settings.glassShadows;
    options.seed = settings.seed;
    options.timeLimit = settings.timeLimit;
    options.noise = settings.noise;
    options.pixelFilter = settings.pixelFilter;
    options.pixelFilterWidth = settings.pixelFilterWidth;
    options.russianRoulette = settings.russianRoulette;
    options.mipBias = settings.mipBias;
    options.shadeIterations = settings.shadeIterations;
    options.waveSize = settings.waveSize;
    options.interactive = settings.interactive;
    options.passSeconds = settings.passSeconds;
    options.traversal = EnumOf<TraversalForm>("traversal", settings.traversal);
    options.kernels = EnumOf<KernelChoice>("kernels", settings.kernels);
    return options;
}

ResidencyOptions MakeResidencyOptions(const Settings& settings) {
    const MemorySize memory = MemoryOf(settings.geometryMemory);
    ResidencyOptions options;
    options.mode = EnumOf<ResidencyMode>("residency", settings.residency);
    options.budgetBytes = memory.bytes;
    options.budgetShare = memory.share;
    options.eviction = EnumOf<Eviction>("geometryEviction", settings.geometryEviction);
    options.requestsFirst = settings.request == "first";
    options.pageEntries = settings.pageEntries;
    const MemorySize textures = MemoryOf(settings.textureMemory);
    options.textureBudgetBytes = textures.bytes;
    options.textureBudgetShare = textures.share;
    const MemorySize volumes = MemoryOf(settings.volumeMemory);
    options.volumeBudgetBytes = volumes.bytes;
    options.volumeBudgetShare = volumes.share;
    options.preparesAll = settings.prepare == "eager";
    return options;
}

CommitOptions MakeCommitOptions(const Settings& settings) {
    CommitOptions options;
    options.purposes = settings.purposes;
    options.drawnPaths = settings.drawnPaths;
    options.hiddenPaths = settings.hiddenPaths;
    options.cullStyle = static_cast<CullStyle>(EnumOf<int>("cullStyle", settings.cullStyle) +
                                               static_cast<int>(CullStyle::Nothing));
    options.domeVisible = settings.domeVisible;
    options.glassShadows = settings.glassShadows;
    options.lightsVisible = settings.lightsVisible;
    options.chunkBytes = settings.chunkBytes;
    // The design of the report has no order in which such chunks could be done.
    options.instanceChunks = settings.request == "first" ? 0 : settings.instanceChunks;
    options.subdivision = EnumOf<Subdivision>("subdivision", settings.subdivision);
    options.autobump = settings.autobump;
    options.refineLevel = options.subdivision == Subdivision::Complexity ? settings.refineLevel : 0;
    const AovLayout aovs = MakeAovLayout(settings.aovs);
    options.shownPrimvars = aovs.primvars;
    options.workingSpace = settings.workingSpace;
    options.keepsNames = aovs.hasMattes;
    return options;
}

} // namespace hds
