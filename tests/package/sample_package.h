#pragma once
/// Small synthetic packages and hand-made zips for the tests of writer and reader.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/pack/pack.h"
#include "runtime/atlas/bytes.h"

namespace beatlas::test {

/// A field whose coefficients are the distance to an ellipsoid-like ball of `radius_mm` that beats
/// by `beat_mm`, with bumps, rounded to 0.01 mm; blocks wholly in or outside the clamp are no
/// leaves, samples that stay clamped are inactive.
[[nodiscard]] atlas::FieldPayload beating_field(Structure structure, double radius_mm,
                                                double beat_mm, int phases, double voxel_mm);

/// A subdivided octahedron (4^levels * 8 triangles) that beats and twists; vertices shuffled.
/// Places, segments and a wall of 8 to 13 mm, thicker at the front, on a surface of
/// `beating_surface`; a vertex in 16 has none.
[[nodiscard]] atlas::SurfaceMapPayload beating_map(const atlas::SurfacePayload& surface);

[[nodiscard]] atlas::SurfacePayload beating_surface(Structure structure, double radius_mm,
                                                    double beat_mm, int phases, int levels);

/// Images of a bright ball that beats in a grey that brightens along x, on voxels of 1.25 x 1.25 x
/// 4 mm, and the distance from the ball.
struct SampleImages {
  ImageCycle<float> images;  ///< with noise
  ImageCycle<float> clean;   ///< without
  FieldCycle heart;
  double noise = 0;  ///< standard deviation
};
[[nodiscard]] SampleImages sample_images(int phases, double radius_mm, double noise);

/// heart, lv_blood (of two levels if `levels` is above 1) and a volume, `phases` phases, a manifest
/// with every key filled.
[[nodiscard]] pack::PackageContent sample_content(int phases, double radius_mm, double voxel_mm,
                                                  int levels);
/// A ball of 36 mm around an LV of 22 mm, as a palpation package of 6 phases; every vertex of its
/// map has a wall, and the segment of its place.
[[nodiscard]] pack::PackageContent palpation_content();
/// Below 64 kB.
[[nodiscard]] pack::PackageContent tiny_content();
/// The same with rv_blood and its map, of one level and without a field.
[[nodiscard]] pack::PackageContent golden_content();

/// A zip of stored entries, written by hand from the format's description: names may repeat or be
/// of any bytes.
[[nodiscard]] atlas::Bytes raw_zip(
    const std::vector<std::pair<std::string, atlas::Bytes>>& entries);

/// The entries of a zip of stored entries, read by hand.
[[nodiscard]] std::vector<std::pair<std::string, atlas::Bytes>> raw_unzip(const atlas::Bytes& zip);

[[nodiscard]] atlas::Bytes read_file(const std::filesystem::path& file);
void write_file(const std::filesystem::path& file, const atlas::Bytes& bytes);

/// A new empty folder that is removed with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace beatlas::test
