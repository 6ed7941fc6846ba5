#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/pack/field_error.h"
#include "pipeline/pack/leaf_coder.h"
#include "pipeline/pack/pack.h"
#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/field_payload.h"
#include "runtime/base/error.h"

namespace beatlas::pack {
namespace {

using atlas::FieldPayload;

// A term is rounded down up to this share of a count: fewer counts are not 0.
constexpr double kRoundUpFrom = 0.6;

// Share of terms that are not 0 below which a leaf is smooth. With 0.14 a beating sphere is stored
// to 0.004 mm (to 0.007 without) for 3 % of bytes on a heart from images; 0.2 takes 6 % and is no
// better.
constexpr double kSmooth = 0.14;

/// Where a leaf is smooth its terms are few, and a finer quantum costs little; where it is rough,
/// the distances themselves are not that exact.
std::uint8_t first_grade(const TermCounts& counts) {
  const auto zeros = std::count(counts.begin(), counts.end(), 0);
  const double share = 1 - static_cast<double>(zeros) / static_cast<double>(counts.size());
  return share < kSmooth / 2 ? 2 : share < kSmooth ? 1 : 0;
}

atlas::Bytes entry_of(const FieldPayload& field, double quantum_mm,
                      const std::vector<std::uint8_t>& grades,
                      const std::vector<TermCounts>& counts) {
  LeafBody body;
  for (const TermCounts& leaf : counts) body.add(leaf);
  atlas::ByteWriter writer;
  writer.put_text(atlas::kFieldMagic);
  writer.put(atlas::kFieldVersion);
  writer.put(static_cast<std::uint32_t>(field.phases));
  for (int count : field.block_count) writer.put(static_cast<std::uint32_t>(count));
  writer.put(static_cast<std::uint32_t>(grades.size()));
  writer.put_many(field.origin_mm.data(), 3);
  for (double value : {field.voxel_mm, field.step_mm, field.inner_mm, field.outer_mm, quantum_mm}) {
    writer.put(value);
  }
  writer.put(static_cast<std::uint32_t>(body.apart_count()));
  for (std::int32_t block : field.blocks) {
    writer.put(static_cast<std::uint8_t>(block == FieldPayload::kOutside  ? 0
                                         : block == FieldPayload::kInside ? 1
                                                                          : 2));
  }
  body.write(grades, writer);
  return zstd_pack(writer.take());
}

/// [leaf] 1 where it should be quantised more finely: a leaf whose error is too large, or, where
/// that is of no help, those around it, which share in its outermost samples.
std::vector<std::uint8_t> leaves_to_refine(const FieldPayload& field,
                                           const std::vector<std::uint8_t>& grades,
                                           const std::vector<double>& errors_mm, double most_mm) {
  std::vector<std::uint8_t> stale(grades.size(), 0);
  const std::vector<LeafNeighbours> around = leaf_neighbours(field);
  for (std::size_t leaf = 0; leaf < errors_mm.size(); ++leaf) {
    if (errors_mm[leaf] <= most_mm) continue;
    if (grades[leaf] < atlas::kMaxGrade) {
      stale[leaf] = 1;
      continue;
    }
    for (const std::int32_t other : around[leaf]) {
      if (other >= 0) stale[static_cast<std::size_t>(other)] = 1;
    }
  }
  return stale;
}

/// Raises the grades of stale leaves that do not have the highest; whether there were any.
bool raise_grades(const std::vector<std::uint8_t>& stale, std::vector<std::uint8_t>& grades) {
  bool any = false;
  for (std::size_t leaf = 0; leaf < grades.size(); ++leaf) {
    if (stale[leaf] == 0 || grades[leaf] == atlas::kMaxGrade) continue;
    ++grades[leaf];
    any = true;
  }
  return any;
}

}  // namespace

atlas::Bytes pack_field(const FieldPayload& field, double step_mm) {
  atlas::check_field(field);
  const std::string name(structure_name(field.structure));
  if (!(step_mm >= kLeastStepMm && step_mm <= kMostStepMm)) {
    throw Error(ErrorCode::Usage, "a field's step must be from 0.0005 to 0.1 mm");
  }
  const LeafCoder coder(field.coefficients, field.phases, atlas::LeafTransform::Of::Spline,
                        step_mm / field.step_mm, {kRoundUpFrom, kRoundUpFrom});
  const double most_mm = kMostErrorSteps * step_mm;
  std::vector<std::uint8_t> grades(field.leaf_count(), 0);
  std::vector<TermCounts> counts(grades.size());
  std::vector<std::uint8_t> stale(grades.size(), 0);
  parallel_for(grades.size(), [&](std::size_t leaf) {
    counts[leaf] = coder.counts(leaf, 0);
    grades[leaf] = first_grade(counts[leaf]);
    stale[leaf] = grades[leaf] > 0 ? 1 : 0;
  });
  for (;;) {
    parallel_for(grades.size(), [&](std::size_t leaf) {
      if (stale[leaf] != 0) counts[leaf] = coder.counts(leaf, grades[leaf]);
    });
    atlas::Bytes entry = entry_of(field, step_mm, grades, counts);
    const std::vector<double> errors =
        leaf_errors_mm(field, atlas::decode_field(entry, field.structure));
    if (std::all_of(errors.begin(), errors.end(), [&](double e) { return e <= most_mm; })) {
      return entry;
    }
    stale = leaves_to_refine(field, grades, errors, most_mm);
    if (!raise_grades(stale, grades)) {
      throw_invalid("the field of " + name + " cannot be stored within " + std::to_string(most_mm) +
                    " mm; give a larger step_mm");
    }
  }
}

atlas::FieldPayload stored_field(const FieldCycle& field, const EncodeOptions& options) {
  const FieldPayload encoded = encode_field(field, options);
  return atlas::decode_field(pack_field(encoded, field_step_mm(encoded.structure, options)),
                             encoded.structure);
}

}  // namespace beatlas::pack
