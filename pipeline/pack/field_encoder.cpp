#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/field_payload.h"
#include "runtime/atlas/residual.h"
#include "runtime/base/error.h"

namespace beatlas::pack {
namespace {

using atlas::FieldPayload;

std::vector<std::uint8_t> block_states(const FieldPayload& field) {
  std::vector<std::uint8_t> states;
  states.reserve(field.blocks.size());
  for (std::int32_t block : field.blocks) {
    states.push_back(block == FieldPayload::kOutside ? 0 : block == FieldPayload::kInside ? 1 : 2);
  }
  return states;
}

/// Low bytes, then high bytes, of all residuals.
std::vector<std::uint8_t> residual_planes(const FieldPayload& field) {
  const auto phases = static_cast<std::size_t>(field.phases);
  const std::size_t total = field.coefficients.size();
  const std::size_t samples = total / phases;
  std::vector<std::uint8_t> planes(2 * total);
  for (const FieldPayload::Leaf& leaf : field.leaves) {
    atlas::LeafPredictor predictor(field, leaf);
    for (std::size_t phase = 0; phase < phases; ++phase) {
      predictor.start_phase(phase == 0);
      std::size_t sample = leaf.first_active;
      for (std::uint16_t rank : predictor.active()) {
        const std::int16_t* cycle = field.coefficients.data() + sample * phases;
        const int before = phase == 0 ? 0 : cycle[phase - 1];
        const auto difference = static_cast<std::uint16_t>(cycle[phase] - before);
        const std::uint16_t code =
            atlas::zigzag(static_cast<std::uint16_t>(difference - predictor.predict(rank)));
        predictor.set(rank, difference);
        const std::size_t at = phase * samples + sample;
        planes[at] = static_cast<std::uint8_t>(code & 0xFFU);
        planes[total + at] = static_cast<std::uint8_t>(code >> 8U);
        ++sample;
      }
    }
  }
  return planes;
}

}  // namespace

atlas::Bytes pack_field(const FieldPayload& field) {
  atlas::check_field(field);
  atlas::ByteWriter writer;
  writer.put_text(atlas::kFieldMagic);
  writer.put(atlas::kFieldVersion);
  writer.put(static_cast<std::uint32_t>(field.phases));
  for (int count : field.block_count) writer.put(static_cast<std::uint32_t>(count));
  writer.put(static_cast<std::uint32_t>(field.leaves.size()));
  writer.put(static_cast<std::uint64_t>(field.coefficients.size()) /
             static_cast<std::uint64_t>(field.phases));
  writer.put_many(field.origin_mm.data(), 3);
  for (double value : {field.voxel_mm, field.step_mm, field.inner_mm, field.outer_mm}) {
    writer.put(value);
  }
  const std::vector<std::uint8_t> states = block_states(field);
  writer.put_many(states.data(), states.size());
  for (const FieldPayload::Leaf& leaf : field.leaves) {
    writer.put_many(leaf.active.data(), leaf.active.size());
    writer.put_many(leaf.inside.data(), leaf.inside.size());
  }
  const std::vector<std::uint8_t> planes = residual_planes(field);
  writer.put_many(planes.data(), planes.size());
  atlas::Bytes entry = zstd_pack(writer.take());
  if (atlas::decode_field(entry, field.structure).coefficients != field.coefficients) {
    throw Error(ErrorCode::Machine, "the field of " + std::string(structure_name(field.structure)) +
                                        " was not read back as it was packed; check the memory");
  }
  return entry;
}

}  // namespace beatlas::pack
