#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/pack/field_error.h"
#include "pipeline/pack/pack.h"
#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/field_payload.h"
#include "runtime/atlas/field_transform.h"
#include "runtime/base/error.h"

namespace beatlas::pack {
namespace {

using atlas::FieldPayload;
using atlas::LeafTransform;

constexpr std::size_t kSamples = FieldPayload::kBlockSamples;
constexpr std::size_t kEdge = FieldPayload::kBlockEdge;
// A term is rounded down up to this share of a count: fewer counts are not 0.
constexpr double kRoundUpFrom = 0.6;

// Share of terms that are not 0 below which a leaf is smooth. With 0.14 a beating sphere is stored
// to 0.004 mm (to 0.007 without) for 3 % of bytes on a heart from images; 0.2 takes 6 % and is no
// better.
constexpr double kSmooth = 0.14;

/// Counts of one leaf's terms, [mode][rank].
using Counts = std::vector<std::int32_t>;

class LeafCoder {
 public:
  LeafCoder(const FieldPayload& field, double quantum_mm)
      : field_(field),
        quantum_(quantum_mm / field.step_mm),
        transform_(field.phases),
        phases_(static_cast<std::size_t>(field.phases)) {}

  [[nodiscard]] Counts counts(std::size_t leaf, int grade) const {
    const std::vector<double> terms = forward(leaf);
    const double quantum = std::ldexp(quantum_, -grade);
    Counts out(kSamples * phases_);
    for (std::size_t mode = 0; mode < phases_; ++mode) {
      for (std::size_t rank = 0; rank < kSamples; ++rank) {
        const double size = quantum *
                            static_cast<double>(transform_.mode_scale(static_cast<int>(mode))) *
                            static_cast<double>(transform_.place_scale(static_cast<int>(rank)));
        const double share = terms[mode * kSamples + transform_.order()[rank]] / size;
        const double count = std::floor(std::abs(share) + (1 - kRoundUpFrom));
        if (!(count < 1e9)) throw_invalid("a field's step is too small for its distances");
        out[mode * kSamples + rank] = static_cast<std::int32_t>(std::copysign(count, share));
      }
    }
    return out;
  }

 private:
  /// Terms in counts of the payload's step, [mode][place].
  [[nodiscard]] std::vector<double> forward(std::size_t leaf) const {
    std::vector<double> out(kSamples * phases_);
    const std::int16_t* from = field_.coefficients.data() + leaf * kSamples * phases_;
    for (std::size_t row = 0; row < kSamples / kEdge; ++row) {
      for (std::size_t phase = 0; phase < phases_; ++phase, from += kEdge) {
        for (std::size_t mode = 0; mode < phases_; ++mode) {
          const double weight = transform_.weight(static_cast<int>(mode), static_cast<int>(phase));
          double* to = &out[mode * kSamples + row * kEdge];
          for (std::size_t x = 0; x < kEdge; ++x) to[x] += weight * from[x];
        }
      }
    }
    std::array<double, kEdge> line{};
    for (const std::size_t stride : {std::size_t{1}, kEdge, kEdge * kEdge}) {
      for (std::size_t n = 0; n < out.size(); ++n) {
        if (n / stride % kEdge != 0) continue;
        for (std::size_t k = 0; k < kEdge; ++k) {
          line[k] = 0;
          for (std::size_t s = 0; s < kEdge; ++s) {
            line[k] +=
                transform_.cosine(static_cast<int>(k), static_cast<int>(s)) * out[n + s * stride];
          }
        }
        for (std::size_t k = 0; k < kEdge; ++k) out[n + k * stride] = line[k];
      }
    }
    return out;
  }

  const FieldPayload& field_;
  double quantum_;
  LeafTransform transform_;
  std::size_t phases_;
};

/// Where a leaf is smooth its terms are few, and a finer quantum costs little; where it is rough,
/// the distances themselves are not that exact.
std::uint8_t first_grade(const Counts& counts) {
  const auto zeros = std::count(counts.begin(), counts.end(), 0);
  const double share = 1 - static_cast<double>(zeros) / static_cast<double>(counts.size());
  return share < kSmooth / 2 ? 2 : share < kSmooth ? 1 : 0;
}

std::uint32_t zigzag(std::int32_t count) {
  return static_cast<std::uint32_t>(count) << 1U ^ static_cast<std::uint32_t>(count >> 31);
}

/// What follows the header.
class Body {
 public:
  void add(const Counts& counts) {
    const std::size_t before = apart_.size();
    for (std::size_t first = 0; first < counts.size(); first += kSamples) {
      std::size_t length = kSamples;
      while (length > 0 && counts[first + length - 1] == 0) --length;
      lengths_.push_back(static_cast<std::uint16_t>(length));
      for (std::size_t b = 0; b < atlas::kBands && atlas::kBandEnds[b] < length; ++b) {
        const std::size_t end = std::min(length, atlas::kBandEnds[b + 1]);
        const bool paired = b >= atlas::kFirstPairedBand;
        for (std::size_t rank = atlas::kBandEnds[b]; rank < end; rank += paired ? 2 : 1) {
          const auto fitted = [&](std::size_t at, std::uint32_t apart_from) {
            const std::uint32_t code = at < end ? zigzag(counts[first + at]) : 0;
            if (code < apart_from) return code;
            apart_.push_back(code);
            return apart_from;
          };
          if (!paired) {
            bands_[b].push_back(static_cast<std::uint8_t>(fitted(rank, atlas::kApartByte)));
            continue;
          }
          const std::uint32_t above = fitted(rank, atlas::kApartHalf);
          bands_[b].push_back(
              static_cast<std::uint8_t>(above << 4U | fitted(rank + 1, atlas::kApartHalf)));
        }
      }
    }
    apart_counts_.push_back(static_cast<std::uint32_t>(apart_.size() - before));
  }
  [[nodiscard]] std::size_t apart_count() const { return apart_.size(); }
  void write(atlas::ByteWriter& writer) const {
    writer.put_many(lengths_.data(), lengths_.size());
    writer.put_many(apart_counts_.data(), apart_counts_.size());
    for (const auto& band : bands_) writer.put_many(band.data(), band.size());
    writer.put_many(apart_.data(), apart_.size());
  }

 private:
  std::vector<std::uint16_t> lengths_;
  std::vector<std::uint32_t> apart_counts_;
  std::array<std::vector<std::uint8_t>, atlas::kBands> bands_;
  std::vector<std::uint32_t> apart_;
};

atlas::Bytes entry_of(const FieldPayload& field, double quantum_mm,
                      const std::vector<std::uint8_t>& grades, const std::vector<Counts>& counts) {
  Body body;
  for (const Counts& leaf : counts) body.add(leaf);
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
  writer.put_many(grades.data(), grades.size());
  body.write(writer);
  return zstd_pack(writer.take());
}

}  // namespace

atlas::Bytes pack_field(const FieldPayload& field, double step_mm) {
  atlas::check_field(field);
  const std::string name(structure_name(field.structure));
  if (!(step_mm >= kLeastStepMm && step_mm <= kMostStepMm)) {
    throw Error(ErrorCode::Usage, "step_mm must be from 0.0005 to 0.1 mm");
  }
  const LeafCoder coder(field, step_mm);
  const double most_mm = kMostErrorSteps * step_mm;
  std::vector<std::uint8_t> grades(field.leaf_count(), 0);
  std::vector<Counts> counts(grades.size());
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
    // A leaf whose error is too large is quantised more finely; where that is of no help, those
    // around it are, which share in its outermost samples.
    std::fill(stale.begin(), stale.end(), std::uint8_t{0});
    const std::vector<LeafNeighbours> around = leaf_neighbours(field);
    for (std::size_t leaf = 0; leaf < errors.size(); ++leaf) {
      if (errors[leaf] <= most_mm) continue;
      if (grades[leaf] < atlas::kMaxGrade) {
        stale[leaf] = 1;
        continue;
      }
      for (const std::int32_t other : around[leaf]) {
        if (other >= 0) stale[static_cast<std::size_t>(other)] = 1;
      }
    }
    bool any = false;
    for (std::size_t leaf = 0; leaf < grades.size(); ++leaf) {
      if (stale[leaf] == 0 || grades[leaf] == atlas::kMaxGrade) continue;
      ++grades[leaf];
      any = true;
    }
    if (!any) {
      throw_invalid("the field of " + name + " cannot be stored within " + std::to_string(most_mm) +
                    " mm; give a larger step_mm");
    }
  }
}

atlas::FieldPayload stored_field(const FieldCycle& field, const EncodeOptions& options) {
  const FieldPayload encoded = encode_field(field, options);
  return atlas::decode_field(pack_field(encoded, options.step_mm), encoded.structure);
}

}  // namespace beatlas::pack
