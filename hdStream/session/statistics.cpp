// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/statistics.h"

#include "hdStream/base/version.h"
#include "hdStream/session/settingsTable.h"

#include <nlohmann/json.hpp>

#include <cstdlib>
#include <fstream>
#include <sys/resource.h>

namespace hds {

namespace {

using Json = nlohmann::ordered_json;

/// The most memory that this process has had. What getrusage says begins with the peak of the
/// process that started it: it is for systems without /proc.
std::uint64_t HostPeakBytes() {
    const std::string key = "VmHWM:";
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        if (line.compare(0, key.size(), key) == 0) {
            return std::strtoull(line.c_str() + key.size(), nullptr, 10) * 1024U;
        }
    }
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024U;
}

Json TimeSection(const StatisticsInput& in) {
    const RenderStatistics& render = in.tracer->Statistics();
    const StreamingStatistics pool = in.tracer->Buffers().PoolStatistics();
    const TextureStatistics textures = in.tracer->Buffers().Textures().Statistics();
    return {{"load", in.loadSeconds},
            {"translate", in.translateSeconds},
            {"prepare",
             in.commitSeconds + in.pages->Seconds() + textures.openSeconds + render.flattenSeconds},
            {"compile", render.compileSeconds},
            {"trace", render.traceSeconds},
            {"requests", pool.requestSeconds + textures.requestSeconds + textures.readSeconds},
            {"transfer", render.transferSeconds + pool.transferSeconds},
            {"shade", render.shadeSeconds},
            {"firstPixel", in.beforeRenderingSeconds + render.firstImageSeconds},
            {"render", render.renderSeconds},
            {"total", in.totalSeconds}};
}

Json GeometrySection(const StatisticsInput& in) {
    const SceneCounts& counts = in.scene->counts;
    const RenderStatistics& render = in.tracer->Statistics();
    const SceneBuffers& buffers = in.tracer->Buffers();
    const StreamingStatistics pool = buffers.PoolStatistics();
    bool isExact = false;
    const std::uint64_t bytesTotal = in.scene->pages->TotalBytes(&isExact);
    // A word a page is counted; another is what kernels tell of uses.
    const std::uint64_t wordBytes = sizeof(std::uint32_t) * in.scene->pages->NumPages();
    std::uint64_t alwaysResidentBytes = counts.alwaysResidentBytes;
    if (buffers.HasStreamingPool() && buffers.Streaming().HasPageHash()) {
        alwaysResidentBytes += buffers.Streaming().TableBytes() - wordBytes;
    } else if (buffers.HasStreamingPool()) {
        alwaysResidentBytes += wordBytes;
    }
    return {{"mode", buffers.IsStreaming() ? "stream"
                     : buffers.IsMapped()  ? "mapped"
                                           : "resident"},
            {"streamedSamples", render.streamedSamples},
            {"streamedPaths", render.streamedPaths},
            {"meshes", counts.meshes},
            {"curves", counts.curves},
            {"points", counts.points},
            {"splats", counts.splats},
            {"instances", counts.instances},
            {"triangles", counts.triangles},
            {"chunks", counts.chunks},
            {"bytesTotal", bytesTotal},
            {"budget", buffers.PoolBytes()},
            {"peakBytes", buffers.PeakUsedBytes()},
            {"pinnedBytes", buffers.PinnedBytes()},
            {"alwaysResidentBytes", alwaysResidentBytes},
            {"flatTriangles", buffers.Flat().NumTriangles()},
            {"flatCopies", buffers.Flat().NumCopies()},
            {"flatBytes", buffers.Flat().Bytes()},
            {"uniqueBytesLoaded", pool.uniqueBytes},
            {"uploadedBytes", pool.uploadedBytes},
            {"uploads", pool.uploads},
            {"evictions", pool.evictions},
            {"requestsDropped", pool.requestsDropped},
            {"rayBatches", render.rayBatches},
            {"briefBatches", render.briefBatches},
            {"iterations", render.iterations},
            {"maxIterationsPerBatch", render.maxIterationsPerBatch},
            {"raysRelaunched", render.raysRelaunched},
            {"shadingRefetches", pool.groupUploads},
            {"chunksTouched", pool.chunksUsed},
            {"chunksBuilt", in.pages->NumBuilt()},
            {"chunksFromCache", in.pages->NumLoaded()},
            {"chunksAhead", in.sources->NumAhead()},
            {"primsMended", in.primsMended},
            {"estimated", !isExact}};
}

Json TextureSection(const StatisticsInput& in) {
    const SceneCounts& counts = in.scene->counts;
    const SceneTextures& textures = in.tracer->Buffers().Textures();
    const RenderStatistics& render = in.tracer->Statistics();
    const TextureStatistics cache = textures.Statistics();
    const std::uint64_t linesTotal = in.scene->lines->TotalLines();
    return {{"mode", textures.Pool() != nullptr ? "stream" : "resident"},
            {"textures", counts.textures},
            {"bytesSource", counts.textureSourceBytes},
            {"bytesTotal", linesTotal * HDS_LINE_BYTES},
            {"budget", textures.Pool() != nullptr ? textures.BudgetBytes() : textures.Bytes()},
            {"peakBytes", textures.PeakUsedBytes()},
            {"linesTotal", linesTotal},
            {"linesLoaded", cache.linesLoaded},
            {"uniqueBytesLoaded", cache.uniqueBytesLoaded},
            {"uploadedBytes", cache.uploadedBytes},
            {"evictions", cache.evictions},
            {"tableBytes", textures.TableBytes()},
            {"alwaysResidentBytes", textures.PinnedBytes()},
            {"lookups", cache.lookups},
            {"misses", cache.misses},
            {"shadePasses", render.shadePasses},
            {"shadeIterations", render.shadeIterations},
            {"fallbackTexels", cache.fallbackTexels},
            {"setConflicts", cache.setConflicts}};
}

Json VolumeCounts(const SceneCounts& counts) {
    return {{"volumes", counts.volumes},
            {"grids", counts.grids},
            {"bricks", counts.bricks},
            {"bytesTotal", counts.bricks * HDS_BRICK_LINES * HDS_LINE_BYTES},
            {"alwaysResidentBytes", counts.volumeTableBytes}};
}

/// Of what TextureSection counts, the part that is voxels.
Json VolumeSection(const StatisticsInput& in) {
    const SceneTextures& textures = in.tracer->Buffers().Textures();
    const LineTraffic voxels = textures.Statistics().grids;
    Json section = VolumeCounts(in.scene->counts);
    if (textures.Pool() != nullptr) { // bounds of bricks are there too
        section["alwaysResidentBytes"] =
            in.scene->counts.volumeTableBytes +
            in.scene->volumes.numBoundedBricks * sizeof(shared::HdsBrickBounds);
    }
    section["budget"] = textures.VolumeBudgetBytes();
    section["peakBytes"] = textures.VolumePeakUsedBytes();
    section["linesLoaded"] = voxels.linesLoaded;
    section["uniqueBytesLoaded"] = voxels.uniqueBytesLoaded;
    section["uploadedBytes"] = voxels.uploadedBytes;
    section["evictions"] = voxels.evictions;
    return section;
}

} // namespace

std::string MakeStatistics(const StatisticsInput& in) {
    const RenderStatistics& render = in.tracer->Statistics();
    const double rays =
        static_cast<double>(render.cameraRays + render.indirectRays + render.shadowRays);
    Json stats;
    stats["version"] = kVersion;
    stats["device"] = {{"name", in.device->Properties().name},
                       {"memory", in.device->Properties().memoryBytes}};
    stats["image"] = {
        {"width", in.imageWidth}, {"height", in.imageHeight}, {"samples", render.samples}};
    stats["time"] = TimeSection(in);
    stats["memory"] = {
        {"pathState", render.pathStateBytes},
        {"film", render.filmBytes},
        {"deep", render.deepBytes},
        {"tables", in.tracer->Buffers().TableBytes()},
        {"devicePeak", in.device->PeakBytes()},
        {"scene", in.sceneBytes},
        {"arraysKept", in.keptArrays.geometryBytes},
        {"instanceArraysKept", in.keptArrays.instanceBytes},
        {"arrays", ArraySource::Counts().bytes},
        {"arraysReadAgain", ArraySource::Counts().readBytes - in.arrayBytesReadBefore},
        {"sourcesPeak", in.sources->PeakBytes()},
        {"sourcesMade", in.sources->NumMade()},
        {"hostPeak", HostPeakBytes()}};
    stats["geometry"] = GeometrySection(in);
    stats["texture"] = TextureSection(in);
    stats["volume"] = VolumeSection(in);
    stats["rays"] = {{"camera", render.cameraRays},
                     {"indirect", render.indirectRays},
                     {"shadow", render.shadowRays},
                     {"perSecond", render.renderSeconds > 0.0 ? rays / render.renderSeconds : 0.0}};
    stats["accuracy"] = {
        {"nanSamples", render.nanSamples},
        {"clampedSamples", render.clampedSamples},
        {"endedPasses", render.endedPasses},
        {"endedWalks", render.endedWalks},
        {"deepCrowded", render.deepCrowded},
        {"lightParts", in.scene->lights->numCells},
        {"meanRelativeError", render.meanRelativeError ? Json(*render.meanRelativeError) : Json()}};
    stats["wave"] = {
        {"size", render.waveSize},
        {"traversal",
         FindSetting("traversal")->choices.at(static_cast<std::size_t>(render.traversal))},
        {"kernels", render.hasGeneralKernels ? "general" : "own"}};
    stats["warnings"] = in.warnings;
    return stats.dump(2) + "\n";
}

std::string MakeInfo(const SceneDescription& scene, const CommittedScene& committed,
                     const std::vector<std::string>& warnings) {
    const SceneCounts& counts = committed.counts;
    Json textures = Json::array();
    for (const TextureUse& texture : committed.textures) {
        textures.push_back({{"file", texture.authoredPath},
                            {"width", texture.width},
                            {"height", texture.height},
                            {"channels", texture.channels},
                            {"bytesSource", texture.bytesSource},
                            {"error", texture.error}});
    }
    Json info;
    info["meshes"] = counts.meshes;
    info["curves"] = counts.curves;
    info["points"] = counts.points;
    info["splats"] = counts.splats;
    info["instancers"] = scene.instancers.size();
    info["instances"] = counts.instances;
    info["triangles"] = counts.triangles;
    info["chunks"] = counts.chunks;
    info["geometryBytes"] = committed.pages->TotalBytes();
    info["alwaysResidentBytes"] = counts.alwaysResidentBytes;
    info["materials"] = scene.materials.size();
    info["lights"] = scene.lights.size();
    info["emissiveTriangles"] = counts.emissiveTriangles;
    info["cameras"] = scene.cameras.size();
    info["textures"] = textures;
    info["textureBytesSource"] = counts.textureSourceBytes;
    info["volume"] = VolumeCounts(counts);
    info["warnings"] = warnings;
    return info.dump(2) + "\n";
}

} // namespace hds
