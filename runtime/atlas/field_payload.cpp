#include "runtime/atlas/field_payload.h"

#include <algorithm>

#include "runtime/atlas/leaf_terms.h"
#include "runtime/atlas/manifest.h"
#include "runtime/atlas/payload_check.h"
#include "runtime/atlas/zstd_frame.h"

namespace beatlas::atlas {
namespace {

constexpr int kMaxBlocksAlongAxis = 4096;
constexpr double kMaxClampSteps = 32765;  // FieldPayload::clamp_count must fit

enum BlockState : std::uint8_t { kStateOutside = 0, kStateInside = 1, kStateLeaf = 2 };

void check_header(const FieldPayload& field) {
  for (int axis = 0; axis < 3; ++axis) {
    require(within(field.origin_mm[axis], -1e5, 1e5), "field has no finite origin");
    const int count = field.block_count[static_cast<std::size_t>(axis)];
    require(count >= 1 && count <= kMaxBlocksAlongAxis, "field has a block count out of range");
  }
  require(within(field.voxel_mm, 0.01, 100), "field has a voxel size out of range");
  require(within(field.step_mm, 1e-6, 10), "field has a step out of range");
  require(field.inner_mm > 0 && field.inner_mm <= 1000, "field has an inner clamp out of range");
  require(field.outer_mm > 0 && field.outer_mm <= 1000, "field has an outer clamp out of range");
  require(std::max(field.inner_mm, field.outer_mm) / field.step_mm <= kMaxClampSteps,
          "field has a step too small for its clamps");
  require(field.phases >= 1 && field.phases <= kMaxPhases, "field has a phase count out of range");
}

std::uint64_t block_total(const FieldPayload& field) {
  std::uint64_t total = 1;
  for (int count : field.block_count) total *= static_cast<std::uint64_t>(count);
  return total;
}

}  // namespace

void check_field(const FieldPayload& field) {
  check_header(field);
  require(field.blocks.size() == block_total(field), "field has a block table of a wrong size");
  std::int32_t next_leaf = 0;
  for (std::int32_t block : field.blocks) {
    if (block == FieldPayload::kOutside || block == FieldPayload::kInside) continue;
    require(block == next_leaf, "field has its leaves out of order");
    ++next_leaf;
  }
  require(static_cast<std::uint64_t>(next_leaf) * FieldPayload::kBlockSamples *
                  static_cast<std::uint64_t>(field.phases) ==
              field.coefficients.size(),
          "field has another number of coefficients than its blocks say");
}

FieldPayload decode_field(ByteView entry, Structure structure) {
  const Bytes bytes = zstd_unpack(entry);
  ByteReader reader(bytes);
  reader.expect_magic(kFieldMagic);
  require(reader.get<std::uint32_t>() == kFieldVersion, "field is of an unknown version");
  FieldPayload field;
  field.structure = structure;
  const auto bounded = [&reader](std::uint32_t limit) {
    return static_cast<int>(std::min(reader.get<std::uint32_t>(), limit + 1));
  };
  field.phases = bounded(kMaxPhases);
  for (int& count : field.block_count) count = bounded(kMaxBlocksAlongAxis);
  LeafTerms::Counts counts;
  counts.leaves = reader.get<std::uint32_t>();
  counts.phases = field.phases;
  for (int axis = 0; axis < 3; ++axis) field.origin_mm[axis] = reader.get<double>();
  field.voxel_mm = reader.get<double>();
  field.step_mm = reader.get<double>();
  field.inner_mm = reader.get<double>();
  field.outer_mm = reader.get<double>();
  const auto quantum_mm = reader.get<double>();
  counts.apart = reader.get<std::uint32_t>();
  check_header(field);
  require(within(quantum_mm, 1e-6, 10), "field has a quantum out of range");

  // Every count is at most what it counts in bytes, so no product below can overflow.
  const std::uint64_t blocks = block_total(field);
  const std::uint64_t rest = reader.remaining();
  constexpr std::uint64_t kLeafBytes = sizeof(std::int16_t) * FieldPayload::kBlockSamples;
  const auto phases = static_cast<std::uint64_t>(field.phases);
  require(blocks <= rest && counts.leaves <= rest &&
              blocks + least_term_bytes(counts.leaves, phases) <= rest,
          "field has counts that its size contradicts");
  require(kLeafBytes * counts.leaves * phases <= plausible_bytes(entry.size()),
          "field claims more coefficients than are plausible for its size");

  field.blocks.reserve(static_cast<std::size_t>(blocks));
  std::int32_t leaf_at = 0;
  for (std::byte state : reader.take(static_cast<std::size_t>(blocks))) {
    const auto value = std::to_integer<std::uint8_t>(state);
    require(value <= kStateLeaf, "field has an unknown block state");
    field.blocks.push_back(value == kStateLeaf     ? leaf_at++
                           : value == kStateInside ? FieldPayload::kInside
                                                   : FieldPayload::kOutside);
  }
  require(static_cast<std::size_t>(leaf_at) == counts.leaves,
          "field has another number of leaves than its blocks say");
  const LeafTerms terms(reader, counts, "field");
  field.coefficients.resize(counts.leaves * FieldPayload::kBlockSamples *
                            static_cast<std::size_t>(field.phases));
  terms.decode(LeafTransform(field.phases), quantum_mm / field.step_mm, field.coefficients.data());
  check_field(field);
  return field;
}

}  // namespace beatlas::atlas
