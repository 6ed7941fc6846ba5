/// The volume: what comes back of images, and images for a renderer.

#include "runtime/atlas/volume.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "pipeline/pack/volume_encoder.h"
#include "runtime/atlas/atlas.h"
#include "runtime/atlas/volume_payload.h"
#include "runtime/base/error.h"
#include "tests/package/sample_package.h"

namespace beatlas {
namespace {

using atlas::VolumePayload;

VolumePayload stored(const test::SampleImages& made, const pack::EncodeOptions& options = {}) {
  return atlas::decode_volume(
      pack::pack_volume(made.images, made.noise, made.heart, options).entry);
}

/// [phase][z][y][x], read from the payload as payloads.h lays it out.
std::vector<double> intensities(const VolumePayload& volume) {
  std::vector<double> out;
  const auto blocks = [&](std::size_t axis) { return std::size_t(volume.size[axis] + 7) / 8; };
  for (std::size_t p = 0; p < std::size_t(volume.phases); ++p) {
    for (std::size_t z = 0; z < std::size_t(volume.size[2]); ++z) {
      for (std::size_t y = 0; y < std::size_t(volume.size[1]); ++y) {
        for (std::size_t x = 0; x < std::size_t(volume.size[0]); ++x) {
          const std::size_t block = x / 8 + blocks(0) * (y / 8 + blocks(1) * (z / 8));
          const std::size_t row = (block * 8 + z % 8) * 8 + y % 8;
          out.push_back(volume.offset +
                        volume.step *
                            volume.counts[(row * std::size_t(volume.phases) + p) * 8 + x % 8]);
        }
      }
    }
  }
  return out;
}

double rms(const std::vector<double>& found, const ImageCycle<float>& images) {
  double squares = 0;
  std::size_t n = 0;
  for (const auto& phase : images.phases) {
    for (const float value : phase) {
      squares += (found[n] - double(value)) * (found[n] - double(value));
      ++n;
    }
  }
  EXPECT_EQ(n, found.size());
  return std::sqrt(squares / double(n));
}

TEST(Volume, GivesBackTheImagesButForTheirNoise) {
  const test::SampleImages made = test::sample_images(10, 30, 12);
  const pack::PackedVolume packed = pack::pack_volume(made.images, made.noise, made.heart, {});
  const VolumePayload volume = atlas::decode_volume(packed.entry);
  EXPECT_EQ(volume.size, made.images.grid.size);
  EXPECT_EQ(volume.workspace_from_index.matrix(), made.images.grid.mm_from_index.matrix());
  EXPECT_EQ(volume.phases, 10);
  EXPECT_EQ(volume.noise, 12);
  const std::vector<double> found = intensities(volume);
  // What is lost is about the noise, and what is kept is nearer to the truth than the images are.
  EXPECT_LT(rms(found, made.images), 1.1 * made.noise);
  EXPECT_GT(rms(found, made.images), 0.5 * made.noise);
  EXPECT_LT(rms(found, made.clean), 0.7 * made.noise);
  // PSNR as its definition has it: range over error, of what lies near the heart.
  EXPECT_NEAR(packed.rms_error, rms(found, made.images), 0.1 * packed.rms_error);
  float low = INFINITY;
  float high = -INFINITY;
  for (const auto& phase : made.images.phases) {
    low = std::min(low, *std::min_element(phase.begin(), phase.end()));
    high = std::max(high, *std::max_element(phase.begin(), phase.end()));
  }
  EXPECT_NEAR(packed.psnr_db, 20 * std::log10(double(high - low) / packed.rms_error), 0.5);
}

TEST(Volume, OfCoarserStepsIsSmallerAndOfFinerStepsNearer) {
  const test::SampleImages made = test::sample_images(6, 24, 12);
  std::size_t bytes = SIZE_MAX;
  double error = 0;
  for (const auto& [step, threshold] :
       {std::pair{0.25, 0.0}, {0.5, 1.0}, {1.0, 2.7}, {4.0, 4.0}, {16.0, 8.0}}) {
    pack::EncodeOptions options;
    options.volume_step = step;
    options.volume_threshold = threshold;
    const pack::PackedVolume packed =
        pack::pack_volume(made.images, made.noise, made.heart, options);
    EXPECT_LT(packed.entry.size(), bytes) << step;
    EXPECT_GT(packed.rms_error, error) << step;
    // The transform is orthonormal, so the largest error of a term bounds the root mean square.
    EXPECT_LE(packed.rms_error, std::max(step / 2, threshold) * made.noise) << step;
    EXPECT_EQ(packed.quantum, step * made.noise);
    bytes = packed.entry.size();
    error = packed.rms_error;
  }
  const auto refuse = [&](double step, double threshold) {
    pack::EncodeOptions options;
    options.volume_step = step;
    options.volume_threshold = threshold;
    EXPECT_THROW((void)pack::pack_volume(made.images, 12, made.heart, options), Error)
        << step << " " << threshold;
  };
  for (const double wrong : {0.2, 17.0, double(NAN)}) refuse(wrong, 2.7);
  for (const double wrong : {-0.1, 17.0, double(NAN)}) refuse(1, wrong);
}

TEST(Volume, OfImagesWithoutNoiseIsGoodToANineHundredthOfTheirRange) {
  test::SampleImages made = test::sample_images(5, 24, 0);
  const pack::PackedVolume packed = pack::pack_volume(made.images, 0, made.heart, {});
  // A 2000th of the range counts as noise, terms of 2.2 times that are left out.
  EXPECT_GT(packed.psnr_db, 59.1);
}

TEST(Volume, IsAsGoodInAnyIntensities) {
  test::SampleImages made = test::sample_images(4, 20, 12);
  const pack::PackedVolume plain = pack::pack_volume(made.images, 12, made.heart, {});
  for (auto& phase : made.images.phases) {
    for (float& value : phase) value = 1e-3F * value - 0.5F;
  }
  const pack::PackedVolume scaled = pack::pack_volume(made.images, 0.012, made.heart, {});
  EXPECT_NEAR(scaled.rms_error, 1e-3 * plain.rms_error, 1e-5 * plain.rms_error);
  EXPECT_NEAR(scaled.psnr_db, plain.psnr_db, 0.05);
}

TEST(Volume, IsCoarserWhereTheHeartNeverComes) {
  // The ball reaches 30 mm; a corner of a box of 72 mm is 62 mm from its centre.
  const test::SampleImages made = test::sample_images(4, 30, 12);
  const std::vector<double> found = intensities(stored(made));
  const Index3 size = made.clean.grid.size;
  const auto error_of = [&](int i, int j, int k) {
    double squares = 0;
    for (int p = 0; p < 4; ++p) {
      for (int n = 0; n < 64; ++n) {
        const std::size_t at = made.clean.grid.offset(i + n % 8, j + n / 8, k);
        const double error = found[std::size_t(p) * made.clean.grid.count() + at] -
                             double(made.clean.phases[std::size_t(p)][at]);
        squares += error * error;
      }
    }
    return std::sqrt(squares / 256);
  };
  EXPECT_LT(error_of(size[0] / 16 * 8, 0, size[2] / 2), 0.8 * made.noise);  // at the wall
  EXPECT_LT(error_of(0, 0, 0), 0.8 * made.noise);  // smooth there: coarse steps lose nothing
  const pack::PackedVolume all = pack::pack_volume(made.images, 12, made.heart, {});
  FieldCycle nowhere = made.heart;
  for (auto& phase : nowhere.distance_mm.phases) std::fill(phase.begin(), phase.end(), 6.0F);
  const pack::PackedVolume none = pack::pack_volume(made.images, 12, nowhere, {});
  EXPECT_LT(none.entry.size(), all.entry.size());
  EXPECT_EQ(none.psnr_db, 0);  // nothing lies near
}

TEST(Volume, GivesImagesOfAnyMomentAndForm) {
  const test::SampleImages made = test::sample_images(4, 20, 12);
  const VolumePayload volume = stored(made);
  const std::vector<double> all = intensities(volume);
  const std::size_t count = volume.sample_count();
  std::vector<float> image(count);
  std::vector<float> next(count);
  const auto largest = [&](std::size_t phase, double share) {
    double most = 0;
    for (std::size_t n = 0; n < count; ++n) {
      const double a = all[phase * count + n];
      const double b = all[(phase + 1) % 4 * count + n];
      most = std::max(most, std::abs(double(image[n]) - (a + share * (b - a))));
    }
    return most;
  };
  for (const auto& [beats, phase, share] : {std::tuple{0.0, 0, 0.0},
                                            {0.25, 1, 0.0},
                                            {0.3125, 1, 0.25},
                                            {0.9375, 3, 0.75},
                                            {-0.25, 3, 0.0},
                                            {7.5, 2, 0.0}}) {
    atlas::volume_intensities(volume, beats, image);
    EXPECT_LT(largest(std::size_t(phase), share), 1e-3) << beats;  // floats near 300
  }
  for (const double beats : {double(NAN), double(INFINITY), -1e-20}) {
    atlas::volume_intensities(volume, beats, image);
    EXPECT_LT(largest(0, 0), 1e-3) << beats;
  }

  atlas::volume_intensities(volume, 0.3, image);
  std::vector<std::uint16_t> wide(count);
  atlas::volume_16bit(volume, 0.3, wide);
  const atlas::IntensityWindow window{60, 260};
  std::vector<std::uint8_t> bytes(count);
  atlas::volume_8bit(volume, 0.3, window, bytes);
  // A box of it alone: the same there, and nothing elsewhere.
  std::vector<std::uint8_t> boxed(bytes.size(), 77);
  const std::array<int, 3> low{1, 2, 1};
  const std::array<int, 3> high{volume.size[0] - 2, volume.size[1] - 1, 2};
  atlas::volume_8bit(volume, 0.3, window, boxed, low, high);
  std::size_t at = 0;
  for (int z = 0; z < volume.size[2]; ++z) {
    for (int y = 0; y < volume.size[1]; ++y) {
      for (int x = 0; x < volume.size[0]; ++x, ++at) {
        const bool inside = x >= low[0] && x <= high[0] && y >= low[1] && y <= high[1] &&
                            z >= low[2] && z <= high[2];
        ASSERT_EQ(boxed[at], inside ? bytes[at] : 77) << x << ' ' << y << ' ' << z;
      }
    }
  }
  for (std::size_t n = 0; n < count; ++n) {
    const auto value = double(image[n]);
    ASSERT_NEAR(volume.offset + volume.step * (wide[n] - 32768.0), value, 0.51 * volume.step);
    ASSERT_NEAR(bytes[n], std::clamp((value - 60) / 200 * 255, 0.0, 255.0), 0.51);
  }
  const atlas::IntensityWindow whole = atlas::whole_window(volume);
  EXPECT_LE(whole.low, *std::min_element(all.begin(), all.end()));
  EXPECT_GE(whole.high, *std::max_element(all.begin(), all.end()));
}

TEST(Volume, IsReadOnlyWhereItIsAskedForAndRefusedIfDamaged) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "a.beatlas";
  pack::PackageContent content = test::tiny_content();
  pack::write_package(file, content);
  EXPECT_EQ(atlas::Atlas::open(file, {{Structure::Heart}, {}}).volume(), nullptr);
  const auto volume = atlas::Atlas::open(file, {{}, {}, true}).volume();
  ASSERT_NE(volume, nullptr);
  EXPECT_EQ(volume->counts, atlas::decode_volume(content.volume->entry).counts);
  // A damaged volume harms nobody who only feels.
  atlas::Bytes bytes = test::read_file(file);
  const auto found = std::search(bytes.begin(), bytes.end(), content.volume->entry.begin(),
                                 content.volume->entry.end());
  ASSERT_NE(found, bytes.end());
  *(found + 40) ^= std::byte{1};
  test::write_file(file, bytes);
  EXPECT_NE(atlas::Atlas::open(file, {{Structure::Heart}, {}}).field(Structure::Heart), nullptr);
  EXPECT_THROW((void)atlas::Atlas::open(file, {{}, {}, true}), Error);
}

TEST(Volume, OfImagesThatAreNoneIsRefused) {
  const test::SampleImages made = test::sample_images(3, 12, 5);
  const auto refuse = [&](auto&& change, double noise = 5) {
    test::SampleImages changed = made;
    change(changed.images);
    try {
      (void)pack::pack_volume(changed.images, noise, changed.heart, {});
      FAIL() << "accepted";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    }
  };
  refuse([](auto& images) { images.phases.clear(); });
  refuse([](auto& images) { images.phases[1].pop_back(); });
  refuse([](auto& images) { images.phases[2][7] = NAN; });
  refuse([](auto& images) { images.phases[2][7] = INFINITY; });
  refuse([](auto& images) { images.grid.mm_from_index.linear().setZero(); });
  refuse([](auto&) {}, NAN);
  // All the same everywhere is no error: nothing to see is a picture too.
  test::SampleImages flat = made;
  for (auto& phase : flat.images.phases) std::fill(phase.begin(), phase.end(), 7.0F);
  const VolumePayload volume =
      atlas::decode_volume(pack::pack_volume(flat.images, 0, flat.heart, {}).entry);
  for (const double value : intensities(volume)) ASSERT_NEAR(value, 7, 1e-5);
}

}  // namespace
}  // namespace beatlas
