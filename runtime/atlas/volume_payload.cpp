#include "runtime/atlas/volume_payload.h"

#include <algorithm>
#include <cmath>

#include "runtime/atlas/leaf_terms.h"
#include "runtime/atlas/manifest.h"
#include "runtime/atlas/payload_check.h"
#include "runtime/atlas/zstd_frame.h"

namespace beatlas::atlas {
namespace {

constexpr double kMostCountsAQuantum = 1e7;  // sums of terms stay far within a float

void check_header(const VolumePayload& volume) {
  for (const int size : volume.size) {
    require(size >= 1 && size <= kMaxVolumeEdge, "volume has a size out of range");
  }
  require(volume.phases >= 1 && volume.phases <= kMaxPhases,
          "volume has a phase count out of range");
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      require(within(volume.workspace_from_index.matrix()(row, column), -1e6, 1e6),
              "volume has no finite place");
    }
  }
  require(std::abs(volume.workspace_from_index.linear().determinant()) >= 1e-9,
          "volume has voxels without extent");
  require(within(volume.offset, -1e9, 1e9), "volume has an offset out of range");
  require(within(volume.step, 1e-9, 1e9), "volume has a step out of range");
  require(within(volume.noise, 0, 1e9), "volume has a noise out of range");
}

std::uint64_t block_total(const VolumePayload& volume) {
  std::uint64_t total = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    total *= static_cast<std::uint64_t>(volume.block_count(axis));
  }
  return total;
}

}  // namespace

void check_volume(const VolumePayload& volume) {
  check_header(volume);
  require(block_total(volume) * FieldPayload::kBlockSamples *
                  static_cast<std::uint64_t>(volume.phases) ==
              volume.counts.size(),
          "volume has another number of samples than its size says");
}

VolumePayload decode_volume(ByteView entry) {
  const Bytes bytes = zstd_unpack(entry);
  ByteReader reader(bytes);
  reader.expect_magic(kVolumeMagic);
  require(reader.get<std::uint32_t>() == kVolumeVersion, "volume is of an unknown version");
  VolumePayload volume;
  const auto bounded = [&reader](std::uint32_t limit) {
    return static_cast<int>(std::min(reader.get<std::uint32_t>(), limit + 1));
  };
  volume.phases = bounded(kMaxPhases);
  for (int& size : volume.size) size = bounded(kMaxVolumeEdge);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      volume.workspace_from_index.matrix()(row, column) = reader.get<double>();
    }
  }
  volume.offset = reader.get<double>();
  volume.step = reader.get<double>();
  const auto quantum = reader.get<double>();
  volume.noise = reader.get<double>();
  LeafTerms::Counts counts;
  counts.apart = reader.get<std::uint32_t>();
  counts.phases = volume.phases;
  check_header(volume);
  require(quantum > 0 && quantum / volume.step <= kMostCountsAQuantum,
          "volume has a quantum out of range");

  // At most 2^27 blocks of 2^10 phases: no product below can overflow.
  const std::uint64_t blocks = block_total(volume);
  const auto phases = static_cast<std::uint64_t>(volume.phases);
  require(least_term_bytes(blocks, phases) <= reader.remaining(),
          "volume has counts that its size contradicts");
  const std::uint64_t samples = blocks * FieldPayload::kBlockSamples * phases;
  require(sizeof(std::int16_t) * samples <= plausible_bytes(entry.size()),
          "volume claims more samples than are plausible for its size");
  counts.leaves = static_cast<std::size_t>(blocks);
  const LeafTerms terms(reader, counts, "volume");
  volume.counts.resize(static_cast<std::size_t>(samples));
  terms.decode(LeafTransform(volume.phases, LeafTransform::Of::Values), quantum / volume.step,
               volume.counts.data());
  check_volume(volume);
  return volume;
}

}  // namespace beatlas::atlas
