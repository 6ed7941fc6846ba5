#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "pipeline/core/parallel.h"
#include "pipeline/pack/distance_extension.h"
#include "pipeline/pack/lattice.h"
#include "pipeline/pack/pack.h"
#include "pipeline/pack/spline_prefilter.h"
#include "runtime/base/error.h"

namespace beatlas::pack {
namespace {

using atlas::FieldPayload;

// In every cell that holds a point at least a voxel inside the clamps, some corner lies in the
// band; the spline's support reaches two samples from there.
constexpr int kSupport = 2;
// Beyond the active samples the distance goes on this far, so that its end does not ring back:
// the prefilter's response falls by 0.27 a sample.
constexpr int kExtension = 6;
constexpr double kCountsAStep = 8;  // in memory; what they add to the error is nothing
constexpr double kMaxCount = std::numeric_limits<std::int16_t>::max();

void check(const FieldCycle& field, const EncodeOptions& options) {
  const std::string name(structure_name(field.structure));
  const Grid& grid = field.distance_mm.grid;
  const double step_mm = field_step_mm(field.structure, options);
  if (!(step_mm >= kLeastStepMm && step_mm <= kMostStepMm)) {
    throw Error(ErrorCode::Usage, "a field's step must be from 0.0005 to 0.1 mm");
  }
  if (field.distance_mm.phases.empty() || grid.count() == 0) {
    throw_invalid("the distance field of " + name + " is empty; run the field stage again");
  }
  const Eigen::Matrix3d expected = Eigen::Matrix3d::Identity() * field.voxel_mm;
  if (!(field.voxel_mm > 0) || !grid.mm_from_index.matrix().allFinite() ||
      !((grid.mm_from_index.linear() - expected).cwiseAbs().maxCoeff() <= 1e-6 * field.voxel_mm)) {
    throw_invalid("the distance field of " + name +
                  " is not on an isotropic lattice along the workspace's axes; "
                  "resample it to one voxel size");
  }
  if (!(field.inner_mm >= field.voxel_mm && field.outer_mm >= field.voxel_mm)) {
    std::ostringstream text;
    text << "the distance field of " << name << " is kept from -" << field.inner_mm << " to "
         << field.outer_mm << " mm, less than a voxel of " << field.voxel_mm
         << " mm; keep more or use a finer voxel";
    throw_invalid(text.str());
  }
  for (std::size_t p = 0; p < field.distance_mm.phases.size(); ++p) {
    const std::vector<float>& samples = field.distance_mm.phases[p];
    if (samples.size() != grid.count()) {
      throw_invalid("phase " + std::to_string(p) + " of the distance field of " + name +
                    " does not have the lattice's number of samples");
    }
    for (float sample : samples) {
      if (!std::isfinite(sample)) {
        throw_invalid("phase " + std::to_string(p) + " of the distance field of " + name +
                      " holds a value that is no number");
      }
    }
  }
}

// Samples that are in the band in any phase, or change side unseen between two; on the input's
// lattice.
SampleMask find_seeds(const FieldCycle& field, const Lattice& input) {
  const auto& phases = field.distance_mm.phases;
  SampleMask seeds(input.count());
  parallel_for(static_cast<std::size_t>(input.size[2]), [&](std::size_t k) {
    for (std::size_t s = k * input.slice(); s < (k + 1) * input.slice(); ++s) {
      const bool inside = phases[0][s] < 0;
      for (const std::vector<float>& phase : phases) {
        if (is_in_band(phase[s], field.inner_mm, field.outer_mm) || (phase[s] < 0) != inside) {
          seeds[s] = 1;
          break;
        }
      }
    }
  });
  return seeds;
}

struct Box {
  Index3 low{0, 0, 0};
  Index3 high{-1, -1, -1};  // inclusive
};

Box bounds(const Lattice& lattice, const SampleMask& mask) {
  Box box{lattice.size, {-1, -1, -1}};
  std::size_t s = 0;
  for (int k = 0; k < lattice.size[2]; ++k) {
    for (int j = 0; j < lattice.size[1]; ++j) {
      for (int i = 0; i < lattice.size[0]; ++i, ++s) {
        if (mask[s] == 0) continue;
        const Index3 here{i, j, k};
        for (std::size_t a = 0; a < 3; ++a) {
          box.low[a] = std::min(box.low[a], here[a]);
          box.high[a] = std::max(box.high[a], here[a]);
        }
      }
    }
  }
  return box;
}

void check_margin(const FieldCycle& field, const Lattice& input) {
  for (const std::vector<float>& phase : field.distance_mm.phases) {
    for (int k = 0; k < input.size[2]; ++k) {
      for (int j = 0; j < input.size[1]; ++j) {
        const bool edge_row = k == 0 || j == 0 || k + 1 == input.size[2] || j + 1 == input.size[1];
        const int step = edge_row ? 1 : std::max(1, input.size[0] - 1);
        for (int i = 0; i < input.size[0]; i += step) {
          if (phase[input.offset(i, j, k)] <= 0) {
            throw_invalid("the structure " + std::string(structure_name(field.structure)) +
                          " reaches the edge of its distance lattice; leave a margin around it");
          }
        }
      }
    }
  }
}

// The part of the input that the coefficients need, as its own lattice.
struct Window {
  Lattice lattice;
  Index3 first{0, 0, 0};  // its first sample in the input; may lie before it
};

// Samples of the window; outside the input the distance is outer_mm.
template <class T>
std::vector<T> cut(const Lattice& input, const std::vector<T>& samples, const Window& window,
                   T outside) {
  std::vector<T> out(window.lattice.count(), outside);
  for (int k = 0; k < window.lattice.size[2]; ++k) {
    const int z = k + window.first[2];
    if (z < 0 || z >= input.size[2]) continue;
    for (int j = 0; j < window.lattice.size[1]; ++j) {
      const int y = j + window.first[1];
      if (y < 0 || y >= input.size[1]) continue;
      const int begin = std::max(0, -window.first[0]);
      const int end = std::min(window.lattice.size[0], input.size[0] - window.first[0]);
      if (end <= begin) continue;
      const auto from = samples.begin() +
                        static_cast<std::ptrdiff_t>(input.offset(begin + window.first[0], y, z));
      std::copy(from, from + (end - begin),
                out.begin() + static_cast<std::ptrdiff_t>(window.lattice.offset(begin, j, k)));
    }
  }
  return out;
}

constexpr int kLeafEdge = FieldPayload::kBlockEdge;

// What the blocks of the window hold.
struct Blocks {
  std::vector<std::int32_t> entries;  // as the payload's
  std::vector<Index3> leaves;         // first sample of each in the window
};

// How many samples of a block are active, and how many inside.
struct BlockCounts {
  int active = 0;
  int inside = 0;
};

BlockCounts counts_of(const Lattice& lattice, const Index3& first, const SampleMask& active,
                      const std::vector<float>& distance_mm) {
  BlockCounts out;
  for (int row = 0; row < kLeafEdge * kLeafEdge; ++row) {
    const std::size_t from =
        lattice.offset(first[0], first[1] + row % kLeafEdge, first[2] + row / kLeafEdge);
    for (std::size_t s = from; s < from + kLeafEdge; ++s) {
      out.active += active[s];
      out.inside += distance_mm[s] < 0 ? 1 : 0;
    }
  }
  return out;
}

// Leaves are the blocks with an active sample, or with samples of both sides; signs of samples that
// are not active are the same in every phase.
Blocks find_blocks(const Lattice& lattice, const Index3& block_count, const SampleMask& active,
                   const std::vector<float>& distance_mm) {
  Blocks out;
  for (int bz = 0; bz < block_count[2]; ++bz) {
    for (int by = 0; by < block_count[1]; ++by) {
      for (int bx = 0; bx < block_count[0]; ++bx) {
        const Index3 first{kExtension + bx * kLeafEdge, kExtension + by * kLeafEdge,
                           kExtension + bz * kLeafEdge};
        const BlockCounts counts = counts_of(lattice, first, active, distance_mm);
        if (counts.active == 0 && counts.inside == 0) {
          out.entries.push_back(FieldPayload::kOutside);
        } else if (counts.active == 0 && counts.inside == FieldPayload::kBlockSamples) {
          out.entries.push_back(FieldPayload::kInside);
        } else {
          out.entries.push_back(static_cast<std::int32_t>(out.leaves.size()));
          out.leaves.push_back(first);
        }
      }
    }
  }
  return out;
}

// Calls body(leaf's row offset in the payload, first sample in the window) for each row of leaves.
template <class Body>
void for_each_row(const Lattice& lattice, const Blocks& blocks, const FieldPayload& payload,
                  const Body& body) {
  parallel_for(blocks.leaves.size(), [&](std::size_t leaf) {
    const Index3& first = blocks.leaves[leaf];
    for (int row = 0; row < kLeafEdge * kLeafEdge; ++row) {
      const int y = row % kLeafEdge;
      const int z = row / kLeafEdge;
      body(payload.row_at(static_cast<std::int32_t>(leaf), y, z),
           lattice.offset(first[0], first[1] + y, first[2] + z));
    }
  });
}

}  // namespace

FieldPayload encode_field(const FieldCycle& field, const EncodeOptions& options) {
  check(field, options);
  const Lattice input{field.distance_mm.grid.size};
  check_margin(field, input);
  const SampleMask seeds = find_seeds(field, input);
  const Box band = bounds(input, seeds);
  if (band.high[0] < 0) {
    throw_invalid("the distance field of " + std::string(structure_name(field.structure)) +
                  " holds no surface; run the field stage again");
  }

  constexpr int kMargin = kSupport + kExtension;
  FieldPayload payload;
  Window window;
  for (std::size_t a = 0; a < 3; ++a) {
    const int needed = band.high[a] - band.low[a] + 1 + 2 * kSupport;
    payload.block_count[a] = (needed + kLeafEdge - 1) / kLeafEdge;
    window.first[a] = band.low[a] - kMargin;
    window.lattice.size[a] = payload.block_count[a] * kLeafEdge + 2 * kExtension;
  }
  const Lattice& lattice = window.lattice;
  const SampleMask active = dilate(lattice, cut<std::uint8_t>(input, seeds, window, 0), kSupport);
  const std::size_t phase_count = field.distance_mm.phases.size();
  std::vector<std::vector<float>> phases(phase_count);
  parallel_for(phase_count, [&](std::size_t p) {
    phases[p] = cut(input, field.distance_mm.phases[p], window, static_cast<float>(field.outer_mm));
  });
  Blocks blocks = find_blocks(lattice, payload.block_count, active, phases.front());
  SampleMask region = active;
  for (const Index3& first : blocks.leaves) {
    for (int row = 0; row < kLeafEdge * kLeafEdge; ++row) {
      const std::size_t from =
          lattice.offset(first[0], first[1] + row % kLeafEdge, first[2] + row / kLeafEdge);
      std::fill_n(region.begin() + static_cast<std::ptrdiff_t>(from), kLeafEdge, std::uint8_t{1});
    }
  }
  region = dilate(lattice, region, kExtension);
  parallel_for(phase_count, [&](std::size_t p) {
    extend_distance(lattice, region, field.voxel_mm, field.inner_mm, field.outer_mm, phases[p]);
  });
  prefilter_cycle(lattice, phases);

  payload.structure = field.structure;
  payload.voxel_mm = field.voxel_mm;
  payload.origin_mm = field.distance_mm.grid.mm(
      window.first[0] + kExtension, window.first[1] + kExtension, window.first[2] + kExtension);
  payload.phases = static_cast<int>(phase_count);
  payload.inner_mm = field.inner_mm;
  payload.outer_mm = field.outer_mm;
  payload.blocks = std::move(blocks.entries);
  payload.coefficients.resize(blocks.leaves.size() * FieldPayload::kBlockSamples * phase_count);

  std::vector<double> largest(blocks.leaves.size());
  for_each_row(lattice, blocks, payload, [&](std::size_t to, std::size_t from) {
    double& most = largest[to / (FieldPayload::kBlockSamples * phase_count)];
    for (const std::vector<float>& phase : phases) {
      for (std::size_t x = 0; x < kLeafEdge; ++x) {
        most = std::max(most, std::abs(static_cast<double>(phase[from + x])));
      }
    }
  });
  // A count that is beyond the clamps must fit too (FieldPayload::clamp_count).
  payload.step_mm = std::max({field_step_mm(field.structure, options) / kCountsAStep,
                              *std::max_element(largest.begin(), largest.end()) / kMaxCount,
                              std::max(field.inner_mm, field.outer_mm) / (kMaxCount - 2)});
  for_each_row(lattice, blocks, payload, [&](std::size_t to, std::size_t from) {
    for (const std::vector<float>& phase : phases) {
      for (std::size_t x = 0; x < kLeafEdge; ++x) {
        const double count = static_cast<double>(phase[from + x]) / payload.step_mm;
        payload.coefficients[to++] =
            static_cast<std::int16_t>(std::lround(std::clamp(count, -kMaxCount, kMaxCount)));
      }
    }
  });
  return payload;
}

}  // namespace beatlas::pack
