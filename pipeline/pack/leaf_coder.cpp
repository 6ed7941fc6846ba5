#include "pipeline/pack/leaf_coder.h"

#include <algorithm>
#include <cmath>

#include "runtime/base/error.h"

namespace beatlas::pack {
namespace {

using atlas::LeafTransform;

constexpr std::size_t kSamples = LeafTransform::kSamples;
constexpr std::size_t kRow = atlas::FieldPayload::kBlockEdge;

std::uint32_t zigzag(std::int32_t count) {
  return static_cast<std::uint32_t>(count) << 1U ^ static_cast<std::uint32_t>(count >> 31);
}

/// The cosine transform of every row of samples along one axis, `stride` apart.
void transform_rows(const LeafTransform& transform, std::size_t stride,
                    std::vector<double>& terms) {
  std::array<double, kRow> line{};
  for (std::size_t n = 0; n < terms.size(); ++n) {
    if (n / stride % kRow != 0) continue;
    for (std::size_t k = 0; k < kRow; ++k) {
      line[k] = 0;
      for (std::size_t s = 0; s < kRow; ++s) {
        line[k] +=
            transform.cosine(static_cast<int>(k), static_cast<int>(s)) * terms[n + s * stride];
      }
    }
    for (std::size_t k = 0; k < kRow; ++k) terms[n + k * stride] = line[k];
  }
}

}  // namespace

LeafCoder::LeafCoder(const std::vector<std::int16_t>& coefficients, int phases,
                     LeafTransform::Of of, double quantum, const Rounding& rounding)
    : coefficients_(coefficients),
      quantum_(quantum),
      rounding_(rounding),
      transform_(phases, of),
      phases_(static_cast<std::size_t>(phases)) {}

TermCounts LeafCoder::counts(std::size_t leaf, int grade) const {
  const std::vector<double> terms = forward(leaf);
  const double quantum = std::ldexp(quantum_, -grade);
  TermCounts out(kSamples * phases_);
  for (std::size_t mode = 0; mode < phases_; ++mode) {
    for (std::size_t rank = 0; rank < kSamples; ++rank) {
      const double size = quantum *
                          static_cast<double>(transform_.mode_scale(static_cast<int>(mode))) *
                          static_cast<double>(transform_.place_scale(static_cast<int>(rank)));
      const double share = terms[mode * kSamples + transform_.order()[rank]] / size;
      const double count = std::abs(share) < rounding_.zero_below
                               ? 0
                               : std::floor(std::abs(share) + (1 - rounding_.round_up_from));
      if (!(count < 1e9)) throw_invalid("a quantisation step is too small for its values");
      out[mode * kSamples + rank] = static_cast<std::int32_t>(std::copysign(count, share));
    }
  }
  return out;
}

std::vector<double> LeafCoder::forward(std::size_t leaf) const {
  std::vector<double> out(kSamples * phases_);
  const std::int16_t* from = coefficients_.data() + leaf * kSamples * phases_;
  for (std::size_t row = 0; row < kSamples / kRow; ++row) {
    for (std::size_t phase = 0; phase < phases_; ++phase, from += kRow) {
      for (std::size_t mode = 0; mode < phases_; ++mode) {
        const double weight = transform_.weight(static_cast<int>(mode), static_cast<int>(phase));
        double* to = &out[mode * kSamples + row * kRow];
        for (std::size_t x = 0; x < kRow; ++x) to[x] += weight * from[x];
      }
    }
  }
  for (const std::size_t stride : {std::size_t{1}, kRow, kRow * kRow}) {
    transform_rows(transform_, stride, out);
  }
  return out;
}

void LeafBody::add(const TermCounts& counts) {
  const std::size_t before = apart_.size();
  for (std::size_t first = 0; first < counts.size(); first += kSamples) {
    std::size_t length = kSamples;
    while (length > 0 && counts[first + length - 1] == 0) --length;
    lengths_.push_back(static_cast<std::uint16_t>(length));
    for (std::size_t b = 0; b < atlas::kBands && atlas::kBandEnds[b] < length; ++b) {
      add_band(b, counts.data() + first, length);
    }
  }
  apart_counts_.push_back(static_cast<std::uint32_t>(apart_.size() - before));
}

void LeafBody::add_band(std::size_t band, const std::int32_t* terms, std::size_t length) {
  const std::size_t end = std::min(length, atlas::kBandEnds[band + 1]);
  const auto fitted = [&](std::size_t rank, std::uint32_t apart_from) {
    const std::uint32_t code = rank < end ? zigzag(terms[rank]) : 0;
    if (code < apart_from) return code;
    apart_.push_back(code);
    return apart_from;
  };
  const bool paired = band >= atlas::kFirstPairedBand;
  for (std::size_t rank = atlas::kBandEnds[band]; rank < end; rank += paired ? 2 : 1) {
    if (!paired) {
      bands_[band].push_back(static_cast<std::uint8_t>(fitted(rank, atlas::kApartByte)));
      continue;
    }
    const std::uint32_t above = fitted(rank, atlas::kApartHalf);
    bands_[band].push_back(
        static_cast<std::uint8_t>(above << 4U | fitted(rank + 1, atlas::kApartHalf)));
  }
}

void LeafBody::write(const std::vector<std::uint8_t>& grades, atlas::ByteWriter& writer) const {
  writer.put_many(grades.data(), grades.size());
  writer.put_many(lengths_.data(), lengths_.size());
  writer.put_many(apart_counts_.data(), apart_counts_.size());
  for (const auto& band : bands_) writer.put_many(band.data(), band.size());
  writer.put_many(apart_.data(), apart_.size());
}

}  // namespace beatlas::pack
