#include "runtime/atlas/field_payload.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "runtime/atlas/manifest.h"
#include "runtime/atlas/residual.h"
#include "runtime/atlas/zstd_frame.h"

namespace beatlas::atlas {
namespace {

constexpr int kMaxBlocksAlongAxis = 4096;
constexpr const char* kRebuild = "; build the package again";

enum BlockState : std::uint8_t { kStateOutside = 0, kStateInside = 1, kStateLeaf = 2 };

void require(bool ok, const std::string& what) {
  if (!ok) throw_invalid("field " + what + kRebuild);
}

bool within(double value, double low, double high) { return value >= low && value <= high; }

void check_header(const FieldPayload& field) {
  for (int axis = 0; axis < 3; ++axis) {
    require(within(field.origin_mm[axis], -1e5, 1e5), "has no finite origin");
    const int count = field.block_count[static_cast<std::size_t>(axis)];
    require(count >= 1 && count <= kMaxBlocksAlongAxis, "has a block count out of range");
  }
  require(within(field.voxel_mm, 0.01, 100), "has a voxel size out of range");
  require(within(field.step_mm, 1e-6, 10), "has a step out of range");
  require(field.inner_mm > 0 && field.inner_mm <= 1000, "has an inner clamp out of range");
  require(field.outer_mm > 0 && field.outer_mm <= 1000, "has an outer clamp out of range");
  require(field.phases >= 1 && field.phases <= kMaxPhases, "has a phase count out of range");
}

std::uint64_t block_total(const FieldPayload& field) {
  std::uint64_t total = 1;
  for (int count : field.block_count) total *= static_cast<std::uint64_t>(count);
  return total;
}

std::uint32_t count_active(const FieldPayload::Mask& mask) {
  int count = 0;
  for (std::uint64_t word : mask) count += std::popcount(word);
  return static_cast<std::uint32_t>(count);
}

void decode_coefficients(ByteReader& reader, FieldPayload& field, std::uint64_t active) {
  const auto phases = static_cast<std::size_t>(field.phases);
  const auto total = static_cast<std::size_t>(active) * phases;
  const ByteView low = reader.take(total);
  const ByteView high = reader.take(total);
  field.coefficients.resize(total);
  const auto plane = static_cast<std::size_t>(active);
  for (const FieldPayload::Leaf& leaf : field.leaves) {
    LeafPredictor predictor(field, leaf);
    for (std::size_t phase = 0; phase < phases; ++phase) {
      predictor.start_phase(phase == 0);
      std::size_t sample = leaf.first_active;
      for (std::uint16_t rank : predictor.active()) {
        const std::size_t at = phase * plane + sample;
        const auto code = static_cast<std::uint16_t>(std::to_integer<unsigned>(low[at]) |
                                                     std::to_integer<unsigned>(high[at]) << 8);
        const auto difference =
            static_cast<std::uint16_t>(predictor.predict(rank) + unzigzag(code));
        predictor.set(rank, difference);
        std::int16_t* cycle = field.coefficients.data() + sample * phases;
        const auto before = phase == 0 ? std::uint16_t{0} : std::uint16_t(cycle[phase - 1]);
        cycle[phase] = static_cast<std::int16_t>(static_cast<std::uint16_t>(before + difference));
        ++sample;
      }
    }
  }
}

}  // namespace

LeafPredictor::LeafPredictor(const FieldPayload& field, const FieldPayload::Leaf& leaf) {
  const auto outside = static_cast<std::uint16_t>(std::lround(field.outer_mm / field.step_mm));
  const auto inside = static_cast<std::uint16_t>(-std::lround(field.inner_mm / field.step_mm));
  for (int rank = 0; rank < FieldPayload::kBlockSamples; ++rank) {
    const auto word = static_cast<std::size_t>(rank / 64);
    const std::uint64_t bit = std::uint64_t{1} << (rank % 64);
    if ((leaf.active[word] & bit) != 0) {
      active_.push_back(static_cast<std::uint16_t>(rank));
    } else {
      constant_[static_cast<std::size_t>(rank)] = (leaf.inside[word] & bit) != 0 ? inside : outside;
    }
  }
}

void LeafPredictor::start_phase(bool first) {
  difference_.fill(0);
  if (!first) return;
  for (int rank = 0; rank < FieldPayload::kBlockSamples; ++rank) {
    difference_[static_cast<std::size_t>(padded(rank))] = constant_[static_cast<std::size_t>(rank)];
  }
}

std::uint16_t LeafPredictor::predict(std::uint16_t rank) const noexcept {
  constexpr int kX = 1;
  constexpr int kY = kEdge;
  constexpr int kZ = kEdge * kEdge;
  const std::uint16_t* d = difference_.data() + padded(rank);
  return static_cast<std::uint16_t>(d[-kX] + d[-kY] + d[-kZ] - d[-kX - kY] - d[-kX - kZ] -
                                    d[-kY - kZ] + d[-kX - kY - kZ]);
}

void LeafPredictor::set(std::uint16_t rank, std::uint16_t difference) noexcept {
  difference_[static_cast<std::size_t>(padded(rank))] = difference;
}

void check_field(const FieldPayload& field) {
  check_header(field);
  require(field.blocks.size() == block_total(field), "has a block table of a wrong size");
  std::int32_t next_leaf = 0;
  for (std::int32_t block : field.blocks) {
    if (block == FieldPayload::kOutside || block == FieldPayload::kInside) continue;
    require(block == next_leaf, "has its leaves out of order");
    ++next_leaf;
  }
  require(static_cast<std::size_t>(next_leaf) == field.leaves.size(),
          "has another number of leaves than its blocks say");
  std::uint64_t active = 0;
  for (const FieldPayload::Leaf& leaf : field.leaves) {
    require(leaf.first_active == active, "has a wrong first sample in a leaf");
    for (std::size_t word = 0; word < leaf.active.size(); ++word) {
      require((leaf.active[word] & leaf.inside[word]) == 0, "has an inside bit at a stored sample");
    }
    active += count_active(leaf.active);
    require(active <= UINT32_MAX, "has too many samples");
  }
  require(field.coefficients.size() == active * static_cast<std::uint64_t>(field.phases),
          "has another number of coefficients than its masks say");
}

FieldPayload decode_field(ByteView entry, Structure structure) {
  const Bytes bytes = zstd_unpack(entry);
  ByteReader reader(bytes);
  reader.expect_magic(kFieldMagic);
  require(reader.get<std::uint32_t>() == kFieldVersion, "is of an unknown version");
  FieldPayload field;
  field.structure = structure;
  const auto bounded = [&reader](std::uint32_t limit) {
    return static_cast<int>(std::min(reader.get<std::uint32_t>(), limit + 1));
  };
  field.phases = bounded(kMaxPhases);
  for (int& count : field.block_count) count = bounded(kMaxBlocksAlongAxis);
  const auto leaf_count = reader.get<std::uint32_t>();
  const auto active_count = reader.get<std::uint64_t>();
  for (int axis = 0; axis < 3; ++axis) field.origin_mm[axis] = reader.get<double>();
  field.voxel_mm = reader.get<double>();
  field.step_mm = reader.get<double>();
  field.inner_mm = reader.get<double>();
  field.outer_mm = reader.get<double>();
  check_header(field);

  // Every count is at most what it counts in bytes, so no product below can overflow.
  const std::uint64_t blocks = block_total(field);
  const std::uint64_t rest = reader.remaining();
  constexpr std::uint64_t kLeafBytes = 2 * sizeof(FieldPayload::Mask);
  require(blocks <= rest && leaf_count <= rest && active_count <= rest &&
              rest == blocks + kLeafBytes * leaf_count +
                          2 * active_count * static_cast<std::uint64_t>(field.phases),
          "has counts that its size contradicts");

  field.blocks.reserve(static_cast<std::size_t>(blocks));
  std::int32_t leaf_at = 0;
  for (std::byte state : reader.take(static_cast<std::size_t>(blocks))) {
    const auto value = std::to_integer<std::uint8_t>(state);
    require(value <= kStateLeaf, "has an unknown block state");
    field.blocks.push_back(value == kStateLeaf     ? leaf_at++
                           : value == kStateInside ? FieldPayload::kInside
                                                   : FieldPayload::kOutside);
  }
  require(static_cast<std::uint32_t>(leaf_at) == leaf_count,
          "has another number of leaves than its blocks say");
  field.leaves.resize(leaf_count);
  std::uint64_t active = 0;
  for (FieldPayload::Leaf& leaf : field.leaves) {
    reader.get_many(leaf.active.data(), leaf.active.size());
    reader.get_many(leaf.inside.data(), leaf.inside.size());
    leaf.first_active = static_cast<std::uint32_t>(active);
    active += count_active(leaf.active);
  }
  require(active == active_count, "has another number of samples than its masks say");
  decode_coefficients(reader, field, active);
  check_field(field);
  return field;
}

}  // namespace beatlas::atlas
