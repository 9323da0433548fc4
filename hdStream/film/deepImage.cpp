// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/deepImage.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <tuple>

namespace hds {

namespace {

constexpr std::uint32_t kNoNode = std::numeric_limits<std::uint32_t>::max();

} // namespace

void DeepSums::Reset(std::uint32_t width, std::uint32_t height, const DeepLimits& limits) {
    const std::size_t numPixels = std::size_t{width} * height;
    _width = width;
    _height = height;
    _limits = limits;
    _numSamples.assign(numPixels, 0);
    _heads.assign(numPixels, kNoNode);
    _chunks.clear();
    _numNodes = 0;
    _numCrowded = 0;
}

std::uint64_t DeepSums::Bytes() const {
    return _numSamples.size() * 2 * sizeof(std::uint32_t) +
           _chunks.size() * kChunkSize * sizeof(Node);
}

DeepSums::Node& DeepSums::Append(std::uint32_t pixel, const DeepHit& hit) {
    if (_numNodes == _chunks.size() * kChunkSize) {
        _chunks.push_back(std::make_unique<std::array<Node, kChunkSize>>());
    }
    Node& node = At(_numNodes);
    node.surface = hit.surface;
    node.first = node.least = node.most = hit.depth;
    node.next = _heads[pixel];
    _heads[pixel] = _numNodes++;
    return node;
}

/// The node that a sample joins.
DeepSums::Node& DeepSums::Find(std::uint32_t pixel, const DeepHit& hit) {
    Node* nearest = nullptr;
    std::uint32_t count = 0;
    for (std::uint32_t index = _heads[pixel]; index != kNoNode; index = At(index).next) {
        Node& node = At(index);
        const float difference = std::fabs(hit.depth - node.first);
        if (node.surface == hit.surface &&
            difference <= _limits.tolerance * std::fabs(node.first)) {
            return node;
        }
        if (nearest == nullptr || difference < std::fabs(hit.depth - nearest->first)) {
            nearest = &node;
        }
        ++count;
    }
    if (nearest == nullptr || count < _limits.mostSamples) {
        return Append(pixel, hit);
    }
    ++_numCrowded;
    return *nearest;
}

void DeepSums::Add(std::uint32_t pixel, const DeepHit& hit) {
    AddNothing(pixel);
    DeepHit known = hit;
    known.depth = hit.depth < _limits.farDepth ? hit.depth : _limits.farDepth; // also of a NaN
    Node& node = Find(pixel, known);
    node.least = std::min(node.least, known.depth);
    node.most = std::max(node.most, known.depth);
    for (std::size_t c = 0; c < 4; ++c) {
        node.sum[c] += hit.radiance[c];
    }
}

/// \param nodes scratch memory.
void DeepSums::MakePixel(std::uint32_t pixel, std::vector<Node>* nodes, DeepImage* image) const {
    nodes->clear();
    for (std::uint32_t index = _heads[pixel]; index != kNoNode; index = At(index).next) {
        nodes->push_back(At(index));
    }
    std::sort(nodes->begin(), nodes->end(), [](const Node& a, const Node& b) {
        return std::tie(a.least, a.most, a.surface, a.first) <
               std::tie(b.least, b.most, b.surface, b.first);
    });
    double left = _numSamples[pixel]; // samples that nothing before has covered
    for (std::size_t i = 0; i < nodes->size(); ++i) {
        Node& node = (*nodes)[i];
        // Two that begin at one depth would have no order for who reads them: they are one.
        for (; i + 1 < nodes->size() && (*nodes)[i + 1].least == node.least; ++i) {
            const Node& same = (*nodes)[i + 1];
            node.most = std::max(node.most, same.most);
            std::transform(node.sum.begin(), node.sum.end(), same.sum.begin(), node.sum.begin(),
                           std::plus<>());
        }
        DeepSample sample;
        sample.z = node.least;
        sample.zBack =
            i + 1 < nodes->size() ? std::min(node.most, (*nodes)[i + 1].least) : node.most;
        for (std::size_t c = 0; c < 4 && left > 0.0; ++c) {
            sample.color[c] = static_cast<float>(node.sum[c] / left);
        }
        left -= node.sum[3];
        image->samples.push_back(sample);
        ++image->counts[pixel];
    }
}

DeepImage DeepSums::Make() const {
    DeepImage image;
    image.width = _width;
    image.height = _height;
    image.counts.assign(_numSamples.size(), 0);
    image.samples.reserve(_numNodes);
    std::vector<Node> nodes;
    for (std::uint32_t pixel = 0; pixel < _numSamples.size(); ++pixel) {
        MakePixel(pixel, &nodes, &image);
    }
    return image;
}

} // namespace hds
