#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipeline/core/shapes.h"
#include "pipeline/core/stage_context.h"
#include "runtime/atlas/bytes.h"
#include "runtime/atlas/manifest.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::pack {

inline constexpr double kLeastStepMm = 0.0005;
inline constexpr double kMostStepMm = 0.1;
inline constexpr double kMostErrorSteps = 2;
inline constexpr double kLeastVolumeStep = 0.25;
inline constexpr double kMostVolumeStep = 16;

struct EncodeOptions {
  /// [mm] kLeastStepMm..kMostStepMm: quantisation of distances. At samples and phases the stored
  /// distance is within kMostErrorSteps of them (the writer sees to it), in the root mean square a
  /// third of one; of a smooth surface still less. Heart of the phantom adult from images: 0.01
  /// takes 36 % more bytes, 0.03 17 % fewer; at 0.02 the normal turns by 0.36 degrees rms.
  double step_mm = 0.02;
  /// The same of the structures within the heart, which no palpation of the heart touches: 0.04
  /// takes a quarter of their bytes off and adds 0.001 mm to their mean error (phantom adult).
  double nested_step_mm = 0.02;
  /// [mm] 0.002..0.5: a stored vertex lies within it of where it was, in every phase; root mean
  /// square along an axis is 0.3 of it, as of rounding to it (14 bits of a heart of 164 mm at
  /// 0.01). At 0.01 it is below the triangles' own error (0.005 mm at edges of 2 mm).
  double surface_step_mm = 0.01;
  /// kLeastVolumeStep..kMostVolumeStep: quantisation of the volume's terms, in standard deviations
  /// of the images' noise; see volume_encoder.h.
  double volume_step = 2;
  /// 0..kMostVolumeStep: terms of less are taken for noise. Of pure noise 2.8 % are larger
  /// than 2.2.
  double volume_threshold = 2.2;
};

/// That of a structure's distances.
[[nodiscard]] constexpr double field_step_mm(Structure structure,
                                             const EncodeOptions& options) noexcept {
  return structure == Structure::Heart ? options.step_mm : options.nested_step_mm;
}

/// Samples -> prefiltered space-time spline coefficients, made sparse; the writer quantises them.
///
/// Active are the samples that lie within the clamps in any phase, or change side between two, and
/// two samples around them, so that the spline's support is complete wherever the distance is at
/// least a voxel within the clamps (FieldSample::in_band); blocks with an active sample are leaves.
/// The clamped distance is carried on beyond its clamps first (distance_extension.h): else the
/// prefilter would ring back into the band in space and, where the band sweeps, in time. Two voxels
/// within the clamps a smooth surface's distance is right to 0.02 mm (tested at 1.5 mm voxels:
/// 0.004), one voxel within to 0.04. Counts are of an eighth of field_step_mm, or larger where
/// a coefficient would not fit 16 bits; `step_mm` of the payload says what it is. Memory: one float
/// more a sample and phase of the leaves' bounding box.
/// @throws Error{InvalidInput} if the field is empty, holds no surface or what is no number, is
/// clamped within a voxel, is not on an isotropic lattice along the axes, or its structure reaches
/// the lattice's edge; Error{Usage} if the step is out of range.
[[nodiscard]] atlas::FieldPayload encode_field(const FieldCycle& field,
                                               const EncodeOptions& options);

/// The field as a package holds it: encoded, stored and read again. @throws as encode_field
[[nodiscard]] atlas::FieldPayload stored_field(const FieldCycle& field,
                                               const EncodeOptions& options);

/// The volume's entry, and how well it gives back the images near the heart.
struct PackedVolume {
  atlas::Bytes entry;
  int phases = 0;
  double noise = 0;      ///< as given
  double quantum = 0;    ///< of terms near the heart, in the images' intensities
  double rms_error = 0;  ///< of intensities near the heart, most of it noise that was left out
  double psnr_db = 0;    ///< 20 log10 of the images' range there over rms_error
};

/// What goes into a package; `manifest.items` is filled by the writer.
struct PackageContent {
  atlas::Manifest manifest;
  std::vector<atlas::FieldPayload> fields;
  std::vector<atlas::SurfacePayload> surfaces;
  /// Of surfaces that are given, with their vertices; empty where the LV's wall is not known.
  std::vector<atlas::SurfaceMapPayload> maps = {};
  std::optional<PackedVolume> volume = std::nullopt;  ///< none: the heart was not made from images
};

/// Writes to a temporary name beside `file` and renames. The same content gives the same bytes.
/// @param options steps of fields and surfaces
/// @param look called with the whole package under its temporary name; may be empty
/// @throws Error{Machine} if it cannot be written; Error{Usage} if an option is out of range; what
/// `look` throws. What had the name before stays then.
void write_package(const std::filesystem::path& file, const PackageContent& content,
                   const EncodeOptions& options = {},
                   const std::function<void(const std::filesystem::path& temporary)>& look = {});

/// Draco's bits a coordinate for a surface of this extent (the longest edge of its box).
[[nodiscard]] int draco_bits(double extent_mm, double surface_step_mm);

}  // namespace beatlas::pack
