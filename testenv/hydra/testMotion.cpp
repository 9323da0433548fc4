// SPDX-License-Identifier: Apache-2.0
// What moves by other means than transforms: lights that change while the shutter is open, as a
// scene index tells them, and velocities, of which some are no numbers.
#include "hydraTest.h"

#include <pxr/base/gf/quath.h>
#include <pxr/imaging/hd/light.h>
#include <pxr/imaging/hd/lightSchema.h>
#include <pxr/imaging/hd/retainedDataSource.h>
#include <pxr/imaging/hd/retainedSceneIndex.h>
#include <pxr/imaging/hd/xformSchema.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace hydraHost {

namespace {

/// The values of the lines of a prim's description that begin with `name`, in their order.
std::vector<std::string> DumpLines(Host& host, const std::string& prim, const std::string& name) {
    const std::string file = ::testing::TempDir() + "hydraMotion.txt";
    EXPECT_TRUE(
        host.Delegate().InvokeCommand(TfToken("dumpScene"), {{TfToken("file"), VtValue(file)}}));
    std::vector<std::string> lines;
    std::ifstream stream(file);
    bool isPrims = false;
    for (std::string line; std::getline(stream, line);) {
        if (line.compare(0, 1, " ") != 0) {
            isPrims = line == prim;
        } else if (isPrims && line.compare(2, name.size(), name) == 0) {
            lines.push_back(line.substr(2 + name.size()));
        }
    }
    return lines;
}

// --- Lights -------------------------------------------------------------------------------------

/// A value that changes evenly, or rests.
template <typename T>
class Ramp final : public HdTypedSampledDataSource<T> {
public:
    HD_DECLARE_DATASOURCE(Ramp<T>);

    VtValue GetValue(HdSampledDataSource::Time time) override {
        return VtValue(GetTypedValue(time));
    }
    T GetTypedValue(HdSampledDataSource::Time time) override { return _atFrame + time * _change; }
    bool
    GetContributingSampleTimesForInterval(HdSampledDataSource::Time start,
                                          HdSampledDataSource::Time end,
                                          std::vector<HdSampledDataSource::Time>* times) override {
        if (_change == T(0)) {
            return false;
        }
        if (times) {
            *times = {start, end};
        }
        return true;
    }

private:
    Ramp(const T& atFrame, const T& change) : _atFrame(atFrame), _change(change) {}

    T _atFrame;
    T _change; ///< a frame
};

/// Of a light: names and data sources.
using Inputs = std::vector<std::pair<TfToken, HdDataSourceBaseHandle>>;

const SdfPath kLamp("/lamp");

class MovingLights : public HydraTest {
protected:
    /// A small lamp 2 above a floor of 2 x 2, with these inputs.
    void Begin(const Inputs& inputs, int samples = 2) {
        SceneData scene = EmptyScene();
        scene.lights.clear();
        scene.gprims[SdfPath("/floor")] = MakeGrid(2.0F, 2.0F);
        HostOptions options = Quick({HdAovTokens->color}, samples);
        options.settings[TfToken("lightsVisible")] = VtValue(false); // to the camera
        _host = std::make_unique<Host>(scene, options);
        _index = HdRetainedSceneIndex::New();
        AddLamp(inputs);
        _host->Index().InsertSceneIndex(_index, SdfPath::AbsoluteRootPath(), false);
    }
    void AddLamp(const Inputs& inputs) {
        TfTokenVector names;
        std::vector<HdDataSourceBaseHandle> values;
        for (const auto& [name, value] : inputs) {
            names.push_back(name);
            values.push_back(value);
        }
        const auto matrix =
            HdRetainedTypedSampledDataSource<GfMatrix4d>::New(Translation(0.0, 0.0, 2.0));
        _index->AddPrims(
            {{kLamp, HdPrimTypeTokens->sphereLight,
              HdRetainedContainerDataSource::New(
                  HdXformSchema::GetSchemaToken(),
                  HdXformSchema::Builder().SetMatrix(matrix).Build(),
                  HdLightSchema::GetSchemaToken(),
                  HdRetainedContainerDataSource::New(names.size(), names.data(), values.data()))}});
    }
    /// Precondition: the same inputs, with other values.
    void EditLamp(const Inputs& inputs) {
        AddLamp(inputs);
        _index->DirtyPrims({{kLamp, HdLightSchema::GetDefaultLocator()}});
    }
    void TearDown() override {
        if (_host) {
            _host->Index().RemoveSceneIndex(_index);
        }
    }
    /// The members of each "light at TIME" line of the lamp, its time first.
    std::vector<std::vector<double>> Samples() {
        std::vector<std::vector<double>> rows;
        for (const std::string& line : DumpLines(*_host, "light /lamp", "light at ")) {
            // "TIME: [COUNT] NUMBERS"
            const std::size_t end = line.find(']');
            std::istringstream stream(line.substr(0, line.find(':')) +
                                      line.substr(std::min(end, line.size() - 1) + 1));
            std::vector<double>& row = rows.emplace_back();
            for (double value = 0.0; stream >> value;) {
                row.push_back(value);
            }
        }
        return rows;
    }

    HdRetainedSceneIndexRefPtr _index;
    std::unique_ptr<Host> _host;
};

/// Columns of Samples().
enum Column { kTime, kIntensity, kExposure, kRed, kGreen, kBlue, kTemperature, kAngle, kRadius };

TEST_F(MovingLights, AreAsTheirSceneIndexTellsNineTimes) {
    Begin({{HdLightTokens->intensity, Ramp<float>::New(8.0F, 4.0F)},
           {HdLightTokens->exposure, Ramp<float>::New(2.0F, 0.0F)},
           {TfToken("inputs:color"), Ramp<GfVec3f>::New(GfVec3f(0.5F), GfVec3f(0.25F, 0.5F, 0.0F))},
           {HdLightTokens->radius, Ramp<float>::New(0.5F, -0.5F)}});
    _host->Frame();
    EXPECT_TRUE(Samples().empty()) << "the shutter is closed";
    for (const auto& [open, close] : {std::pair(-0.25, 0.75), std::pair(0.0, 0.5)}) {
        SetShutter(*_host, open, close);
        _host->Frame();
        const std::vector<std::vector<double>> samples = Samples();
        ASSERT_EQ(samples.size(), 9U);
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const std::vector<double>& row = samples[i];
            ASSERT_EQ(row.size(), 12U);
            const double time = open + double(i) / 8.0 * (close - open); // all of them exact
            EXPECT_EQ(row[kTime], time);
            EXPECT_EQ(row[kIntensity], 8.0 + 4.0 * time);
            EXPECT_EQ(row[kExposure], 2.0) << "as of the frame";
            EXPECT_EQ(row[kRed], 0.5 + 0.25 * time);
            EXPECT_EQ(row[kGreen], 0.5 + 0.5 * time);
            EXPECT_EQ(row[kBlue], 0.5);
            EXPECT_EQ(row[kRadius], 0.5 - 0.5 * time);
        }
    }
    SetShutter(*_host, 0.0, 0.0);
    _host->Frame();
    EXPECT_TRUE(Samples().empty()) << "the shutter is closed again";
}

TEST_F(MovingLights, ThatRestHaveNoSamples) {
    Begin({{HdLightTokens->intensity, Ramp<float>::New(8.0F, 0.0F)},
           {HdLightTokens->radius, Ramp<float>::New(0.5F, 0.0F)}});
    SetShutter(*_host, -0.5, 0.5);
    _host->Frame();
    EXPECT_TRUE(Samples().empty());
}

/// A host that has known of lamp and shutter from the start draws the same bits.
TEST_F(MovingLights, MayBeEditedAndHaveTheirShutterOpenedLater) {
    const auto inputs = [](float change) {
        return Inputs{{HdLightTokens->intensity, Ramp<float>::New(2000.0F, change)},
                      {HdLightTokens->radius, Ramp<float>::New(0.05F, change * 1e-5F)}};
    };
    Begin(inputs(1000.0F));
    const Image still = _host->Render();
    SetShutter(*_host, -0.5, 0.5);
    const Image blurred = _host->Render();
    EXPECT_NE(blurred, still);
    EditLamp(inputs(3000.0F));
    const Image edited = _host->Render();
    EXPECT_NE(edited, blurred);
    EditLamp(inputs(1000.0F));
    EXPECT_EQ(_host->Render(), blurred);
    SetShutter(*_host, 0.0, 0.0);
    EXPECT_EQ(_host->Render(), still);

    TearDown();
    Begin(inputs(3000.0F));
    SetShutter(*_host, -0.5, 0.5);
    EXPECT_EQ(_host->Render(), edited);
}

/// What a lamp whose radiance alone changes sends to the floor is what it sends at the frame, times
/// the mean of its intensity over the shutter. Samples of time are spread evenly: 64 x 48 pixels of
/// 16 samples know the mean of this ramp to 0.3 % at one standard error, were they independent.
TEST_F(MovingLights, ShineAsBrightAsTheMeanOfTheirIntensity) {
    Begin({{HdLightTokens->intensity, Ramp<float>::New(2000.0F, 4000.0F)},
           {HdLightTokens->radius, Ramp<float>::New(0.01F, 0.0F)}},
          16);
    const auto sum = [&] {
        const Image image = _host->Render();
        double total = 0.0;
        for (int y = 0; y < image.height; ++y) {
            for (int x = 0; x < image.width; ++x) {
                total += double(image.Float(x, y));
            }
        }
        return total;
    };
    const double still = sum();
    ASSERT_GT(still, 0.0);
    for (const auto& [open, close] : {std::pair(-0.5, 0.5), std::pair(0.0, 0.5)}) {
        SetShutter(*_host, open, close);
        EXPECT_NEAR(sum() / still, 1.0 + 2.0 * 0.5 * (open + close), 0.01) << open << " " << close;
    }
}

// --- Velocities ---------------------------------------------------------------------------------

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
const SdfPath kSheet("/sheet");
const std::string kStandStill = "velocities are not finite: points that have these stand still";
const std::string kInstancesStandStill =
    "velocities are not finite: instances that have these stand still";

/// Two quads beside each other that velocities move, by how much a second.
SceneData Sheet(const VtVec3fArray& velocities, const VtVec3fArray& accelerations = {}) {
    SceneData scene = EmptyScene();
    scene.lights[SdfPath("/dome")] = MakeDome(GfVec3f(0.6F, 0.7F, 0.9F));
    GprimData sheet = MakeGrid(1.2F, 0.6F, 2, 1);
    sheet.SetPrimvar("velocities", HdInterpolationVertex, VtValue(velocities));
    if (!accelerations.empty()) {
        sheet.SetPrimvar("accelerations", HdInterpolationVertex, VtValue(accelerations));
    }
    scene.gprims[kSheet] = sheet;
    return scene;
}

VtVec3fArray Moving() {
    return {{0, 24, 0}, {12, 0, 0}, {0, -24, 6}, {0, 12, 0}, {24, 0, 0}, {0, 0, 24}};
}

class Velocities : public HydraTest {
protected:
    /// The picture while the shutter is open, and how often the line about velocities is told.
    std::pair<Image, int> Blurred(const SceneData& scene) {
        Host host(scene, Quick({HdAovTokens->color}, 8));
        SetShutter(host, -0.25, 0.5);
        Image image = host.Render();
        _samples = DumpLines(host, "mesh /sheet", "points at ");
        return {std::move(image), NumWarnings(host, kStandStill)};
    }

    std::vector<std::string> _samples; ///< of the last picture
};

TEST_F(Velocities, ThatAreNotFiniteMoveNothing) {
    const auto [all, numAll] = Blurred(Sheet(Moving()));
    EXPECT_EQ(numAll, 0);
    for (const auto& [x, y, z] : {std::tuple(kNan, 0.0F, 0.0F), std::tuple(0.0F, kInfinity, 3.0F),
                                  std::tuple(0.0F, 0.0F, -kInfinity)}) {
        VtVec3fArray rest = Moving();
        rest[1] = rest[4] = GfVec3f(0.0F);
        const auto [expected, numExpected] = Blurred(Sheet(rest));
        const std::vector<std::string> expectedSamples = _samples;
        EXPECT_EQ(numExpected, 0);
        EXPECT_NE(expected, all);

        VtVec3fArray broken = Moving();
        broken[1] = broken[4] = GfVec3f(x, y, z);
        const auto [found, numFound] = Blurred(Sheet(broken));
        EXPECT_EQ(found, expected) << x << " " << y << " " << z;
        EXPECT_EQ(_samples, expectedSamples);
        EXPECT_EQ(numFound, 1);
    }
}

TEST_F(Velocities, WhoseAccelerationsAreNotFiniteMoveNothing) {
    VtVec3fArray changes(6, GfVec3f(0.0F, 48.0F, 0.0F));
    VtVec3fArray rest = Moving();
    rest[2] = GfVec3f(0.0F);
    changes[2] = GfVec3f(0.0F);
    const auto [expected, numExpected] = Blurred(Sheet(rest, changes));
    EXPECT_EQ(numExpected, 0);
    changes[2] = GfVec3f(0.0F, kNan, 0.0F);
    const auto [found, numFound] = Blurred(Sheet(Moving(), changes));
    EXPECT_EQ(found, expected);
    EXPECT_EQ(numFound, 1);
}

TEST_F(Velocities, AreNotToBlameForPointsThatAreNotFiniteThemselves) {
    SceneData scene = Sheet(Moving());
    PrimvarData* points = scene.gprims[kSheet].FindPrimvar(HdTokens->points);
    auto places = points->value.Get<VtVec3fArray>();
    places[1] = GfVec3f(kNan, 0.0F, 0.0F);
    points->value = VtValue(places);
    EXPECT_EQ(Blurred(scene).second, 0);
}

/// As those of points; also those by which instances turn.
TEST_F(Velocities, OfInstancesThatAreNotFiniteMoveNothing) {
    const SdfPath swarm("/swarm");
    const SdfPath cube("/swarm/cube");
    const auto blurred = [&](const GfVec3f& velocity, const GfVec3f& turn) {
        SceneData scene = EmptyScene();
        scene.lights[SdfPath("/dome")] = MakeDome(GfVec3f(0.6F, 0.7F, 0.9F));
        InstancerData instancer;
        const VtVec3fArray places{{-0.9F, 0, 0}, {0, 0, 0}, {0.9F, 0, 0}};
        const VtQuathArray rotations(3, GfQuath(0.5F, 0.5F, 0.5F, 0.5F));
        const VtVec3fArray velocities{{0, 24, 0}, velocity, {12, 0, 0}};
        const VtVec3fArray turns{{0, 0, 480}, {480, 0, 0}, turn}; // degrees a second
        for (const auto& [name, value] :
             {std::pair(HdInstancerTokens->instanceTranslations, VtValue(places)),
              std::pair(HdInstancerTokens->instanceRotations, VtValue(rotations)),
              std::pair(HdTokens->velocities, VtValue(velocities)),
              std::pair(HdTokens->angularVelocities, VtValue(turns))}) {
            instancer.primvars.push_back({name, HdInterpolationInstance, {}, value, {}});
        }
        instancer.indicesByPrototype = {{cube, {0, 1, 2}}};
        scene.instancers[swarm] = instancer;
        GprimData leaf = MakeCube(0.25F);
        leaf.instancer = swarm;
        scene.gprims[cube] = leaf;
        Host host(scene, Quick({HdAovTokens->color}, 8));
        SetShutter(host, -0.25, 0.5);
        Image image = host.Render();
        return std::pair(std::move(image), NumWarnings(host, kInstancesStandStill));
    };
    const GfVec3f rest(0.0F);
    const auto expected = blurred(rest, rest);
    EXPECT_EQ(expected.second, 0);
    EXPECT_NE(blurred(GfVec3f(0.0F, 24.0F, 0.0F), rest).first, expected.first);
    EXPECT_NE(blurred(rest, GfVec3f(0.0F, 480.0F, 0.0F)).first, expected.first);
    // A number, and so is where it leads, though its square is none of floats.
    EXPECT_EQ(blurred(GfVec3f(0.0F, 2e19F, 0.0F), rest).second, 0);
    for (const GfVec3f& broken : {GfVec3f(0.0F, kNan, 0.0F), GfVec3f(kInfinity, 3.0F, 0.0F)}) {
        EXPECT_EQ(blurred(broken, rest), std::pair(expected.first, 1)) << broken;
        EXPECT_EQ(blurred(rest, broken), std::pair(expected.first, 1)) << broken;
    }
}

} // namespace

} // namespace hydraHost
