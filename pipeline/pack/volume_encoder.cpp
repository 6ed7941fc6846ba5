#include "pipeline/pack/volume_encoder.h"

#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/pack/leaf_coder.h"
#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/volume_payload.h"
#include "runtime/base/error.h"

namespace beatlas::pack {
namespace {

using atlas::VolumePayload;

constexpr std::uint8_t kNearGrade = 1;  // its quantum is half of grade 0's
constexpr double kCountsANoise = 32;    // in memory; what they add to the error is nothing
constexpr double kMostCounts = 60000;   // of the whole range
constexpr double kLeastNoiseOfRange = 1 / 2000.0;
constexpr double kLeastRange = 1e-4;  // of images that are the same everywhere
constexpr int kVolumeEdge = VolumePayload::kBlockEdge;

struct Range {
  double low = 0;
  double high = 0;
};

Range check(const ImageCycle<float>& images, double noise, const EncodeOptions& options) {
  if (!(options.volume_step >= kLeastVolumeStep && options.volume_step <= kMostVolumeStep)) {
    throw Error(ErrorCode::Usage, "volume_step must be from 0.25 to 16");
  }
  if (!(options.volume_threshold >= 0 && options.volume_threshold <= kMostVolumeStep)) {
    throw Error(ErrorCode::Usage, "volume_threshold must be from 0 to 16");
  }
  const std::string advice = "; import them again";
  if (images.phases.empty() || images.grid.count() == 0) {
    throw_invalid("there are no images around the heart" + advice);
  }
  if (!(noise >= 0)) throw_invalid("the noise of the images is no number" + advice);
  Range range{INFINITY, -INFINITY};
  for (const std::vector<float>& phase : images.phases) {
    if (phase.size() != images.grid.count()) {
      throw_invalid("the images around the heart differ in size" + advice);
    }
    for (const float value : phase) {
      if (!std::isfinite(value)) throw_invalid("the images hold what is no number" + advice);
      range.low = std::min(range.low, static_cast<double>(value));
      range.high = std::max(range.high, static_cast<double>(value));
    }
  }
  return range;
}

/// Beyond the images as at their edge, so that the last blocks have no step in them.
void fill_counts(const ImageCycle<float>& images, VolumePayload& volume) {
  const std::size_t phases = images.phases.size();
  const Index3 size = volume.size;
  const auto rows = static_cast<std::size_t>(kVolumeEdge * volume.block_count(1)) *
                    static_cast<std::size_t>(kVolumeEdge * volume.block_count(2));
  parallel_for(rows, [&](std::size_t row) {
    const int y = static_cast<int>(row) % (kVolumeEdge * volume.block_count(1));
    const int z = static_cast<int>(row) / (kVolumeEdge * volume.block_count(1));
    const std::size_t from =
        images.grid.offset(0, std::min(y, size[1] - 1), std::min(z, size[2] - 1));
    for (int block = 0; block < volume.block_count(0); ++block) {
      std::int16_t* to = volume.counts.data() + volume.row_at(block, y, z);
      for (std::size_t p = 0; p < phases; ++p) {
        for (int x = 0; x < kVolumeEdge; ++x) {
          const int i = std::min(kVolumeEdge * block + x, size[0] - 1);
          const auto value =
              static_cast<double>(images.phases[p][from + static_cast<std::size_t>(i)]);
          *to++ = static_cast<std::int16_t>(std::lround((value - volume.offset) / volume.step));
        }
      }
    }
  });
}

/// Blocks with a sample that the heart comes within its outer_mm of; x fastest.
std::vector<std::uint8_t> near_blocks(const VolumePayload& volume, const FieldCycle& heart) {
  const Grid& lattice = heart.distance_mm.grid;
  const double within_mm = heart.outer_mm * (1 - 1e-5);  // the clamp may be rounded to float
  const Affine lattice_from_index = lattice.mm_from_index.inverse() * volume.workspace_from_index;
  const auto is_near = [&](int x, int y, int z) {
    const Vec3 at = lattice_from_index * Vec3(x, y, z);
    const auto nearest = [&](int axis) { return static_cast<int>(std::lround(at[axis])); };
    if (!lattice.contains(nearest(0), nearest(1), nearest(2))) return false;
    const std::size_t sample = lattice.offset(nearest(0), nearest(1), nearest(2));
    return std::any_of(heart.distance_mm.phases.begin(), heart.distance_mm.phases.end(),
                       [&](const std::vector<float>& phase) {
                         return static_cast<double>(phase[sample]) < within_mm;
                       });
  };
  const int along_x = volume.block_count(0);
  const int along_y = volume.block_count(1);
  std::vector<std::uint8_t> out(static_cast<std::size_t>(along_x) *
                                static_cast<std::size_t>(along_y) *
                                static_cast<std::size_t>(volume.block_count(2)));
  parallel_for(out.size(), [&](std::size_t n) {
    const int block = static_cast<int>(n);
    const Index3 first{kVolumeEdge * (block % along_x), kVolumeEdge * (block / along_x % along_y),
                       kVolumeEdge * (block / along_x / along_y)};
    const auto end = [&](std::size_t axis) {
      return std::min(first[axis] + kVolumeEdge, volume.size[axis]);
    };
    for (int z = first[2]; z < end(2) && out[n] == 0; ++z) {
      for (int y = first[1]; y < end(1) && out[n] == 0; ++y) {
        for (int x = first[0]; x < end(0) && out[n] == 0; ++x) out[n] = is_near(x, y, z) ? 1 : 0;
      }
    }
  });
  return out;
}

/// @param threshold in counts; of coarser grades it grows with their quantum
atlas::Bytes entry_of(const VolumePayload& volume, double quantum, double threshold,
                      const std::vector<std::uint8_t>& grades) {
  const LeafCoder coder(volume.counts, volume.phases, atlas::LeafTransform::Of::Values,
                        quantum / volume.step, {std::max(threshold, 0.5), 0.5});
  std::vector<TermCounts> counts(grades.size());
  parallel_for(grades.size(),
               [&](std::size_t leaf) { counts[leaf] = coder.counts(leaf, grades[leaf]); });
  LeafBody body;
  for (const TermCounts& leaf : counts) body.add(leaf);
  atlas::ByteWriter writer;
  writer.put_text(atlas::kVolumeMagic);
  writer.put(atlas::kVolumeVersion);
  writer.put(static_cast<std::uint32_t>(volume.phases));
  for (const int size : volume.size) writer.put(static_cast<std::uint32_t>(size));
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      writer.put(volume.workspace_from_index.matrix()(row, column));
    }
  }
  for (const double value : {volume.offset, volume.step, quantum, volume.noise}) writer.put(value);
  writer.put(static_cast<std::uint32_t>(body.apart_count()));
  body.write(grades, writer);
  return zstd_pack(writer.take());
}

/// Fills what tells of the error, of samples in near blocks.
void measure(const ImageCycle<float>& images, const VolumePayload& stored,
             const std::vector<std::uint8_t>& near, PackedVolume& out) {
  double squares = 0;
  std::size_t count = 0;
  Range range{INFINITY, -INFINITY};
  const int along_x = stored.block_count(0);
  for (int z = 0; z < stored.size[2]; ++z) {
    for (int y = 0; y < stored.size[1]; ++y) {
      for (int x = 0; x < stored.size[0]; ++x) {
        const int block = x / kVolumeEdge +
                          along_x * (y / kVolumeEdge + stored.block_count(1) * (z / kVolumeEdge));
        if (near[static_cast<std::size_t>(block)] == 0) continue;
        const std::int16_t* row =
            stored.counts.data() + stored.row_at(x / kVolumeEdge, y, z) + x % kVolumeEdge;
        const std::size_t at = images.grid.offset(x, y, z);
        for (std::size_t p = 0; p < images.phases.size(); ++p) {
          const auto given = static_cast<double>(images.phases[p][at]);
          const double error = stored.offset + stored.step * row[p * kVolumeEdge] - given;
          squares += error * error;
          range.low = std::min(range.low, given);
          range.high = std::max(range.high, given);
          ++count;
        }
      }
    }
  }
  if (count == 0) return;
  out.rms_error = std::sqrt(squares / static_cast<double>(count));
  const double least = 1e-6 * (range.high - range.low);  // no infinity where nothing is lost
  if (range.high > range.low) {
    out.psnr_db = 20 * std::log10((range.high - range.low) / std::max(out.rms_error, least));
  }
}

}  // namespace

PackedVolume pack_volume(const ImageCycle<float>& images, double noise, const FieldCycle& heart,
                         const EncodeOptions& options) {
  const Range range = check(images, noise, options);
  const double extent = std::max(range.high - range.low, kLeastRange);
  const double counted = std::max(noise, kLeastNoiseOfRange * extent);
  VolumePayload volume;
  volume.size = images.grid.size;
  volume.workspace_from_index = images.grid.mm_from_index;
  volume.phases = images.phase_count();
  volume.offset = (range.low + range.high) / 2;
  volume.step = std::max(counted / kCountsANoise, extent / kMostCounts);
  volume.noise = noise;
  std::size_t blocks = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    blocks *= static_cast<std::size_t>(volume.block_count(axis));
  }
  volume.counts.resize(blocks * atlas::FieldPayload::kBlockSamples * images.phases.size());
  fill_counts(images, volume);
  atlas::check_volume(volume);

  const std::vector<std::uint8_t> near = near_blocks(volume, heart);
  std::vector<std::uint8_t> grades(near.size());
  std::transform(near.begin(), near.end(), grades.begin(),
                 [](std::uint8_t is_near) { return is_near != 0 ? kNearGrade : std::uint8_t{0}; });
  PackedVolume out;
  out.phases = volume.phases;
  out.noise = noise;
  out.quantum = options.volume_step * counted;
  out.entry = entry_of(volume, std::ldexp(out.quantum, kNearGrade),
                       options.volume_threshold / options.volume_step, grades);
  measure(images, atlas::decode_volume(out.entry), near, out);
  return out;
}

}  // namespace beatlas::pack
