// SPDX-License-Identifier: MIT
// The GPU layer: what shaders declare, the barriers that follow from it, device choice, buffers, timestamps.
#include <chrono>
#include <cstddef>
#include <random>
#include <set>

#include "engine/core/error.h"
#include "engine/gpu/recorder.h"
#include "engine/hand/fit.h"
#include "engine/silhouette/silhouette.h"
#include "shaders/hand/fit.comp.h"
#include "shaders/hand/fit_choose.comp.h"
#include "shaders/hull/carve_tiles.comp.h"
#include "shaders/hull/carve_voxels.comp.h"
#include "shaders/hull/distance_lines.comp.h"
#include "shaders/hull/distance_rows.comp.h"
#include "tests/support/gpu_fixture.h"
#include "tests/support/scene.h"

namespace airclay {
namespace {

// --- what a shader declares ---

enum Use { kReads, kWrites, kReadsAndWrites };

struct ExpectedPointer {
  std::size_t offset;
  Use use;
};

/// `last` is the end of the struct's last member.
void expectInterface(std::span<const std::uint32_t> spirv, std::size_t last,
                     const std::vector<ExpectedPointer>& expected) {
  const ShaderInterface found = shaderInterface(spirv);
  EXPECT_EQ(found.push_constant_bytes, last);
  ASSERT_EQ(found.pointers.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    SCOPED_TRACE("pointer " + std::to_string(i));
    EXPECT_EQ(found.pointers[i].offset, expected[i].offset);
    EXPECT_EQ(found.pointers[i].reads, expected[i].use != kWrites);
    EXPECT_EQ(found.pointers[i].writes, expected[i].use != kReads);
  }
}

#define AIRCLAY_END_OF(Args, member) (offsetof(Args, member) + sizeof(Args::member))

TEST(ShaderInterface, OffsetsAndAccessMatchTheCppStructs) {
  expectInterface(carve_tiles_comp, AIRCLAY_END_OF(CarveTileArgs, sums),
                  {{offsetof(CarveTileArgs, cameras), kReads},
                   {offsetof(CarveTileArgs, masks), kReads},
                   {offsetof(CarveTileArgs, tiles), kWrites},
                   {offsetof(CarveTileArgs, mixed_counts), kWrites},
                   {offsetof(CarveTileArgs, sums), kWrites}});
  expectInterface(carve_voxels_comp, AIRCLAY_END_OF(CarveVoxelArgs, voxel_m),
                  {{offsetof(CarveVoxelArgs, cameras), kReads},
                   {offsetof(CarveVoxelArgs, masks), kReads},
                   {offsetof(CarveVoxelArgs, blocks), kReads},
                   {offsetof(CarveVoxelArgs, block_count), kReads},
                   {offsetof(CarveVoxelArgs, words), kWrites},
                   {offsetof(CarveVoxelArgs, sums), kReadsAndWrites}});
  // FieldPlace, a struct with an array, is between the pointers and the last member
  expectInterface(distance_rows_comp, AIRCLAY_END_OF(DistanceRowArgs, voxels),
                  {{offsetof(DistanceRowArgs, brick_states), kReads},
                   {offsetof(DistanceRowArgs, words), kReads},
                   {offsetof(DistanceRowArgs, squares), kWrites}});
  expectInterface(distance_lines_comp, AIRCLAY_END_OF(DistanceLineArgs, cell_m),
                  {{offsetof(DistanceLineArgs, squares), kReads},
                   {offsetof(DistanceLineArgs, next_squares), kWrites},
                   {offsetof(DistanceLineArgs, distances), kWrites}});
  expectInterface(fit_comp, AIRCLAY_END_OF(FitArgs, max_iterations),
                  {{offsetof(FitArgs, patches), kReads},
                   {offsetof(FitArgs, distances), kReads},
                   {offsetof(FitArgs, fits), kReadsAndWrites}});
  expectInterface(fit_choose_comp, AIRCLAY_END_OF(FitChooseArgs, lost_outside_m),
                  {{offsetof(FitChooseArgs, fits), kReads},
                   {offsetof(FitChooseArgs, hull), kReads},
                   {offsetof(FitChooseArgs, result), kWrites},
                   {offsetof(FitChooseArgs, hand), kWrites}});
}

/// Assembles a SPIR-V module.
class Assembler {
 public:
  Assembler() : words_{0x07230203, 0x00010600, 0, 100, 0} {}
  Assembler& add(std::uint32_t op, const std::vector<std::uint32_t>& operands) {
    words_.push_back(std::uint32_t(operands.size() + 1) << 16 | op);
    words_.insert(words_.end(), operands.begin(), operands.end());
    return *this;
  }
  std::span<const std::uint32_t> words() const { return words_; }

 private:
  std::vector<std::uint32_t> words_;
};

// opcodes and enumerants of the SPIR-V specification, section 3
constexpr std::uint32_t kOpTypeInt = 21, kOpTypeArray = 28, kOpTypeStruct = 30, kOpTypePointer = 32,
                        kOpVariable = 59, kOpMemberDecorate = 72;
constexpr std::uint32_t kOffset = 35, kNonWritable = 24, kNonReadable = 25;
constexpr std::uint32_t kPushConstant = 9, kPhysicalStorageBuffer = 5349;

TEST(ShaderInterface, FindsPointersInNestedStructs) {
  // push constants { struct { uint; read-only pointer }; write-only pointer; pointer; uint }
  enum : std::uint32_t { kUint = 1, kRead, kWrite, kBoth, kReadP, kWriteP, kBothP, kInner, kBlock, kBlockP };
  Assembler a;
  a.add(kOpMemberDecorate, {kRead, 0, kOffset, 0}).add(kOpMemberDecorate, {kRead, 0, kNonWritable});
  a.add(kOpMemberDecorate, {kWrite, 0, kOffset, 0}).add(kOpMemberDecorate, {kWrite, 0, kNonReadable});
  a.add(kOpMemberDecorate, {kBoth, 0, kOffset, 0});
  a.add(kOpMemberDecorate, {kInner, 0, kOffset, 0}).add(kOpMemberDecorate, {kInner, 1, kOffset, 8});
  const std::uint32_t offsets[] = {16, 32, 40, 48};
  for (std::uint32_t i = 0; i < 4; ++i) a.add(kOpMemberDecorate, {kBlock, i, kOffset, offsets[i]});
  a.add(kOpTypeInt, {kUint, 32, 0});
  a.add(kOpTypeStruct, {kRead, kUint}).add(kOpTypeStruct, {kWrite, kUint}).add(kOpTypeStruct, {kBoth, kUint});
  a.add(kOpTypePointer, {kReadP, kPhysicalStorageBuffer, kRead});
  a.add(kOpTypePointer, {kWriteP, kPhysicalStorageBuffer, kWrite});
  a.add(kOpTypePointer, {kBothP, kPhysicalStorageBuffer, kBoth});
  a.add(kOpTypeStruct, {kInner, kUint, kReadP});
  a.add(kOpTypeStruct, {kBlock, kInner, kWriteP, kBothP, kUint});
  a.add(kOpTypePointer, {kBlockP, kPushConstant, kBlock});
  a.add(kOpVariable, {kBlockP, 50, kPushConstant});
  expectInterface(a.words(), 52, {{24, kReads}, {32, kWrites}, {40, kReadsAndWrites}});
}

TEST(ShaderInterface, RejectsDamagedShaders) {
  EXPECT_EQ(shaderInterface(Assembler().words()).push_constant_bytes, 0u);
  EXPECT_TRUE(shaderInterface(Assembler().words()).pointers.empty());
  // cut in the middle of the first instruction, OpCapability with two words
  EXPECT_THROW(shaderInterface(std::span(fit_comp).first(6)), Error);
}

TEST(Kernel, RejectsTooShortArguments) {
  EXPECT_THROW(RawKernel(testGpu(), "fit", fit_comp, {8}, 64), Error);
}

// --- barriers from declarations ---

/// The commands that have a barrier before them.
std::vector<bool> barriers(const Recorder& recorder) {
  std::vector<bool> before;
  for (const RecordedCommand& command : recorder.commands()) before.push_back(command.barrier_before);
  return before;
}

TEST(Recorder, BarriersAreExactlyWhereNeeded) {
  Gpu& gpu = testGpu();
  const Buffer<std::uint32_t> a(gpu, 16), b(gpu, 16), c(gpu, 16);
  Recorder recorder(gpu);
  recorder.begin();
  recorder.fill(a.raw(), 1);            // the first command
  recorder.fill(b.raw(), 2);            // independent
  recorder.copy(a.raw(), c.raw(), 64);  // reads written data
  recorder.fill(b.raw(), 3);            // nothing is pending on b since the barrier
  recorder.submitAndWait();
  EXPECT_EQ(barriers(recorder), (std::vector<bool>{false, false, true, false}));

  recorder.begin();
  recorder.copy(a.raw(), b.raw(), 64);
  recorder.copy(a.raw(), c.raw(), 64);  // a second reader
  recorder.fill(a.raw(), 3);            // writes data that is read
  recorder.fill(a.raw(), 4);            // writes data that was written
  recorder.submitAndWait();
  EXPECT_EQ(barriers(recorder), (std::vector<bool>{false, false, true, true}));
  EXPECT_TRUE(hazards(recorder.commands()).empty());
  EXPECT_EQ(a.download(), std::vector<std::uint32_t>(16, 4));
  EXPECT_EQ(b.download(), std::vector<std::uint32_t>(16, 1));
}

TEST(Recorder, DivideSubmitsTheRecordedCommands) {
  Gpu& gpu = testGpu();
  const Buffer<std::uint32_t> a(gpu, 16, Memory::kHost), b(gpu, 16, Memory::kHost);
  Recorder recorder(gpu);
  recorder.begin();
  recorder.stage("first");
  recorder.fill(a.raw(), 1);
  recorder.divide();
  EXPECT_EQ(a.host()[0], 1u) << "it ran";
  recorder.stage("second");
  recorder.copy(a.raw(), b.raw(), 64);
  recorder.fill(a.raw(), 2);
  recorder.submitAndWait();
  EXPECT_EQ(barriers(recorder), (std::vector<bool>{false, true, true}));
  EXPECT_TRUE(hazards(recorder.commands()).empty());
  EXPECT_EQ(b.host()[15], 1u);
  EXPECT_EQ(a.host()[15], 2u);
  ASSERT_EQ(recorder.stageMs().size(), 2u) << "stages are timed across it";
  EXPECT_GT(gpu.takeLongestSubmissionMs(), 0);
  EXPECT_EQ(gpu.takeLongestSubmissionMs(), 0);
}

TEST(Recorder, HazardsArePairsWithoutABarrier) {
  const auto reads = [](std::uint64_t buffer) { return Access{buffer, true, false}; };
  const auto writes = [](std::uint64_t buffer) { return Access{buffer, false, true}; };
  using Pairs = std::vector<std::pair<int, int>>;
  EXPECT_EQ(hazards({{"w", {writes(1)}, false}, {"r", {reads(1)}, false}}), (Pairs{{0, 1}}));
  EXPECT_EQ(hazards({{"r", {reads(1)}, false}, {"w", {writes(1)}, false}}), (Pairs{{0, 1}}));
  EXPECT_EQ(hazards({{"w", {writes(1)}, false}, {"w", {writes(1)}, false}}), (Pairs{{0, 1}}));
  EXPECT_EQ(hazards({{"r", {reads(1)}, false}, {"r", {reads(1)}, false}}), Pairs{});
  EXPECT_EQ(hazards({{"w", {writes(1)}, false}, {"w", {writes(2)}, false}}), Pairs{});
  EXPECT_EQ(hazards({{"w", {writes(1)}, false}, {"r", {reads(1)}, true}}), Pairs{});
  // a barrier in between, though not right before the later one
  EXPECT_EQ(hazards({{"w", {writes(1)}, false}, {"o", {reads(2)}, true}, {"r", {reads(1)}, false}}), Pairs{});
  // a barrier that is too early
  EXPECT_EQ(hazards({{"o", {reads(2)}, false}, {"w", {writes(1)}, true}, {"r", {reads(1)}, false}}),
            (Pairs{{1, 2}}));
}

/// Places barriers like the recorder.
void placeBarriers(std::vector<RecordedCommand>& commands,
                   const std::vector<std::vector<Access>>& declared_accesses) {
  HazardTracker tracker;
  for (std::size_t i = 0; i < commands.size(); ++i)
    commands[i].barrier_before = tracker.needsBarrier(declared_accesses[i]);
}

std::vector<std::vector<Access>> accessesOf(const std::vector<RecordedCommand>& commands) {
  std::vector<std::vector<Access>> accesses;
  for (const RecordedCommand& command : commands) accesses.push_back(command.accesses);
  return accesses;
}

TEST(Recorder, RandomCommandsGetMinimalBarriers) {
  std::mt19937 random(7);
  for (int round = 0; round < 50; ++round) {
    std::vector<RecordedCommand> commands(20);
    for (RecordedCommand& command : commands)
      for (int i = 0; i < 3; ++i) {
        const bool writes = random() % 3 == 0;
        command.accesses.push_back({1 + random() % 8, !writes || random() % 2 == 0, writes});
      }
    placeBarriers(commands, accessesOf(commands));
    EXPECT_TRUE(hazards(commands).empty());
    for (RecordedCommand& command : commands) {
      if (!command.barrier_before) continue;
      command.barrier_before = false;
      EXPECT_FALSE(hazards(commands).empty()) << "a barrier for nothing";
      command.barrier_before = true;
    }
  }
}

TEST(Recorder, RejectsPointersOutsideLiveBuffers) {
  Gpu& gpu = testGpu();
  Kernel<FitChooseArgs> kernel(gpu, "fit_choose", fit_choose_comp);
  const Buffer<GpuFit> fits(gpu, 2), result(gpu, 1);
  const Buffer<GpuHandPose> hand(gpu, 1);
  const Buffer<HullSums> hull(gpu, 1);
  FitChooseArgs args{};
  args.fits = fits;
  args.hull = hull;
  args.result = result;
  args.hand = hand;
  args.count = 1;
  Recorder recorder(gpu);
  recorder.begin();
  recorder.dispatch(kernel, args, 1);
  // the pointer is inside a buffer, its end is not
  args.fits.address = fits.at(1).address;
  EXPECT_NO_THROW(recorder.dispatch(kernel, args, 1));
  args.fits.address = fits.at(2).address;
  EXPECT_THROW(recorder.dispatch(kernel, args, 1), Error);
  {
    const Buffer<GpuFit> gone(gpu, 2);
    args.fits = gone;
  }
  EXPECT_THROW(recorder.dispatch(kernel, args, 1), Error);
  args.fits.address = 12;
  EXPECT_THROW(recorder.dispatch(kernel, args, 1), Error);
  recorder.submitAndWait();
}

TEST(Recorder, RecordsAgainAfterAnError) {
  const Buffer<std::uint32_t> buffer(testGpu(), std::vector<std::uint32_t>(16, 7));
  Recorder recorder(testGpu());
  recorder.begin();
  recorder.fill(buffer.raw(), 1);
  recorder.begin();  // an error interrupted the recording before the submission
  recorder.submitAndWait();
  EXPECT_TRUE(recorder.commands().empty());
  EXPECT_EQ(buffer.download(), std::vector<std::uint32_t>(16, 7));
}

// --- a frame, and the effect of a missing declaration ---

/// The commands of a tracked frame, from images to the pose.
std::vector<RecordedCommand> frameCommands() {
  Gpu& gpu = testGpu();
  const GpuRig rig(gpu, ringRig(3, 64, 48));
  const Buffer<std::uint32_t> images(gpu, rig.imageWords());
  Silhouettes silhouettes(gpu, rig);
  Carver carver(gpu, rig, 32);
  DistanceField field(gpu);
  FitModel model;
  model.patches.resize(1);
  Fitter fitter(gpu, model);
  const Kernel<FitChooseArgs> choose(gpu, "fit_choose", fit_choose_comp);
  const Buffer<GpuFit> fits(gpu, 1), result(gpu, 1);
  const Buffer<GpuHandPose> hand(gpu, 1);
  Recorder recorder(gpu);
  recorder.begin();
  silhouettes.recordLearning(recorder, images);
  silhouettes.finishLearning(recorder);
  recorder.submitAndWait();

  recorder.begin();
  silhouettes.record(recorder, images);
  carver.record(recorder, silhouettes.masks());
  const FieldGrid grid = placeField(carver, Vec3::Zero(), Vec3::Constant(0.2));
  field.record(recorder, carver, grid);
  fitter.record(recorder, field, grid, fits, 1, {});
  FitChooseArgs args{};
  args.fits = fits;
  args.hull = carver.sums();
  args.result = result;
  args.hand = hand;
  args.count = 1;
  recorder.dispatch(choose, args, 1);
  recorder.submitAndWait();
  return recorder.commands();
}

bool conflict(const Access& a, const Access& b) {
  return a.buffer == b.buffer && (a.writes || b.writes);
}

/// Whether the access matters to any other command.
bool conflictsWithAnother(const std::vector<RecordedCommand>& commands, std::size_t command,
                          const Access& access) {
  for (std::size_t other = 0; other < commands.size(); ++other)
    if (other != command)
      for (const Access& theirs : commands[other].accesses)
        if (conflict(access, theirs)) return true;
  return false;
}

TEST(Recorder, DetectsAMissingDeclarationInAFrame) {
  std::vector<RecordedCommand> commands = frameCommands();
  ASSERT_GT(commands.size(), 20u);
  const std::vector<std::vector<Access>> truth = accessesOf(commands);
  placeBarriers(commands, truth);
  ASSERT_TRUE(hazards(commands).empty());

  int matter = 0;
  std::set<std::pair<std::string, std::size_t>> found;  // the kernel, and the index of its pointer
  for (std::size_t c = 0; c < commands.size(); ++c)
    for (std::size_t a = 0; a < truth[c].size(); ++a) {
      if (!conflictsWithAnother(commands, c, truth[c][a])) continue;
      ++matter;
      std::vector<std::vector<Access>> declared = truth;
      declared[c].erase(declared[c].begin() + std::ptrdiff_t(a));
      placeBarriers(commands, declared);
      if (!hazards(commands).empty()) found.insert({commands[c].name, a});
    }
  // the others share their barrier with an access that is still declared
  EXPECT_GE(found.size(), 18u) << "of " << matter;
  const std::pair<std::string, std::size_t> must[] = {
      {"edges", 2},             // its output
      {"majority", 1},          // its input
      {"carve_tiles", 1},       // masks
      {"carve_voxels", 4},      // words
      {"distance_rows", 2},     // squares
      {"distance_lines_y", 0},  // squares
      {"distance_lines_y", 1},  // the next squares
      {"distance_lines_z", 1},  // distances
      {"fit", 1},               // distances
      {"fit", 2},               // fits
      {"fit_choose", 0},        // fits
  };
  for (const auto& [name, pointer] : must)
    EXPECT_TRUE(found.count({name, pointer})) << name << ", pointer " << pointer;
}

TEST(Recorder, DetectsAMissingDeclarationForEveryPair) {
  const std::vector<RecordedCommand> frame = frameCommands();
  int pairs = 0;
  for (std::size_t i = 0; i < frame.size(); ++i)
    for (std::size_t j = i + 1; j < frame.size(); ++j)
      for (std::size_t a = 0; a < frame[i].accesses.size(); ++a)
        for (const Access& later : frame[j].accesses) {
          if (!conflict(frame[i].accesses[a], later)) continue;
          ++pairs;
          // only the accesses of these two commands to this buffer: nothing else forces the barrier
          std::vector<RecordedCommand> two = {{frame[i].name, {frame[i].accesses[a]}, false},
                                              {frame[j].name, {later}, false}};
          placeBarriers(two, accessesOf(two));
          EXPECT_TRUE(hazards(two).empty());
          placeBarriers(two, {{}, {later}});
          EXPECT_FALSE(hazards(two).empty()) << frame[i].name;
          placeBarriers(two, {{frame[i].accesses[a]}, {}});
          EXPECT_FALSE(hazards(two).empty()) << frame[j].name;
        }
  EXPECT_GT(pairs, 50);
}

// --- the device ---

template <class Call>
void expectDeviceFault(Call&& call, const std::string& word) {
  try {
    call();
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.fault(), Fault::kDevice);
    EXPECT_NE(message.find(word), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(Gpu, UnknownDeviceIsAOneLineError) {
  for (const char* name : {"99", "99999999999999999999", "no such card"}) {
    GpuOptions options;
    options.device = name;
    expectDeviceFault([&] { Gpu gpu(options); }, name);
    // and which devices exist instead
    expectDeviceFault([&] { Gpu gpu(options); }, Gpu::devices().at(0).name);
  }
}

TEST(Gpu, SelectsDeviceByIndexOrPartOfItsName) {
  const std::vector<DeviceInfo> devices = Gpu::devices();
  for (std::size_t i = 0; i < devices.size(); ++i) {
    SCOPED_TRACE(devices[i].name);
    GpuOptions options;
    options.device = std::to_string(i);
    if (!devices[i].missing.empty()) {
      expectDeviceFault([&] { Gpu gpu(options); }, devices[i].missing.front());
      continue;
    }
    EXPECT_EQ(Gpu(options).info().name, devices[i].name);
    options.device = devices[i].name.substr(0, devices[i].name.size() / 2);
    EXPECT_NE(Gpu(options).info().name.find(options.device), std::string::npos);
  }
}

TEST(Gpu, VulkanErrorsNameTheCallAndARemedy) {
  EXPECT_NO_THROW(check(VK_SUCCESS, "test"));
  expectDeviceFault([] { check(VK_ERROR_DEVICE_LOST, "wait"); },
                    "could not wait: the Vulkan device was lost");
  expectDeviceFault([] { check(VK_ERROR_OUT_OF_DEVICE_MEMORY, "take memory"); }, "out of memory");
  expectDeviceFault([] { check(VK_ERROR_UNKNOWN, "test"); }, "-13");
}

// --- buffers ---

TEST(Buffer, RoundTripsValues) {
  Gpu& gpu = testGpu();
  std::vector<std::uint32_t> values(100'003);
  std::mt19937 random(1);
  for (std::uint32_t& value : values) value = std::uint32_t(random());
  for (const Memory memory : {Memory::kDevice, Memory::kHost}) {
    Buffer<std::uint32_t> buffer(gpu, values, memory);
    EXPECT_EQ(buffer.count(), values.size());
    EXPECT_EQ(buffer.download(), values);
    Buffer<std::uint32_t> moved = std::move(buffer);
    EXPECT_EQ(moved.download(), values);
    EXPECT_THROW(moved.upload(std::vector<std::uint32_t>(values.size() + 1)), Error);
  }
  const Buffer<std::uint32_t> empty(gpu, 0);
  EXPECT_EQ(empty.count(), 0u);
  EXPECT_NE(empty.raw().address(), 0u);
  EXPECT_TRUE(empty.download().empty());
}

TEST(Buffer, FindsLiveBuffersByAddress) {
  Gpu& gpu = testGpu();
  std::uint64_t address = 0;
  {
    const Buffer<std::uint32_t> buffer(gpu, 10);
    address = buffer.raw().address();
    EXPECT_EQ(gpu.liveBufferAt(address), address);
    EXPECT_EQ(gpu.liveBufferAt(address + 39), address);
    EXPECT_NE(gpu.liveBufferAt(address + 40), address);
    EXPECT_NE(gpu.liveBufferAt(address - 1), address);
  }
  EXPECT_EQ(gpu.liveBufferAt(address), 0u);
}

TEST(Buffer, DetectsWritesPastTheEnd) {
  Gpu& gpu = testGpu();
  // a fit has 352 bytes; the kernel gets 320
  static_assert(sizeof(GpuFit) == 352);
  const Kernel<FitChooseArgs> kernel(gpu, "fit_choose", fit_choose_comp);
  const Buffer<GpuFit> fits(gpu, 1);
  const Buffer<HullSums> hull(gpu, 1);
  const Buffer<GpuHandPose> hand(gpu, 1);
  Buffer<std::uint32_t> small(gpu, 80, Memory::kHost);
  FitChooseArgs args{};
  args.fits = fits;
  args.hull = hull;
  args.result.address = small.raw().address();
  args.hand = hand;
  args.count = 1;
  Recorder recorder(gpu);
  recorder.begin();
  recorder.dispatch(kernel, args, 1);
  recorder.submitAndWait();
  EXPECT_EQ(gpu.damagedGuards(), 1);
  std::memset(small.raw().mapped() + small.raw().bytes(), Gpu::kGuardByte, Gpu::kGuardBytes);
  EXPECT_EQ(gpu.damagedGuards(), 0);
  // and before the start
  small.raw().mapped()[-1] = 0;
  EXPECT_EQ(gpu.damagedGuards(), 1);
  small.raw().mapped()[-1] = Gpu::kGuardByte;
  EXPECT_EQ(gpu.damagedGuards(), 0);
}

// --- time ---

TEST(Recorder, StagesAreTimedByName) {
  Gpu& gpu = testGpu();
  const Buffer<std::uint32_t> large(gpu, 16 << 20), small(gpu, 16);
  Recorder recorder(gpu);
  const auto start = std::chrono::steady_clock::now();
  recorder.begin();
  recorder.stage("much");
  recorder.fill(large.raw(), 1);
  recorder.stage("little");
  recorder.fill(small.raw(), 1);
  recorder.stage("much");
  recorder.fill(large.raw(), 2);
  recorder.submitAndWait();
  const double wall_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  const auto& stages = recorder.stageMs();
  ASSERT_EQ(stages.size(), 2u);
  EXPECT_EQ(stages[0].first, "much");
  EXPECT_EQ(stages[1].first, "little");
  EXPECT_GT(stages[0].second, 0);
  EXPECT_GE(stages[1].second, 0);
  EXPECT_GT(stages[0].second, stages[1].second);
  EXPECT_LT(stages[0].second + stages[1].second, wall_ms);
}

TEST(Recorder, GroupsCoverTheCountWithinDeviceLimits) {
  for (const std::size_t count : {1u, 63u, 64u, 65u, 1'000'000u, 20'000'000u, 300'000'000u}) {
    const GroupRows rows = groupRowsFor(count, 64);
    EXPECT_GE(std::size_t(rows.x) * rows.y * 64, count);
    EXPECT_LE(rows.x, 65'535u);
    EXPECT_LE(rows.y, 65'535u);
    // at most one row too many, by rounding
    EXPECT_LT(std::size_t(rows.x) * rows.y, groupsFor(count, 64) + rows.y);
  }
}

}  // namespace
}  // namespace airclay
