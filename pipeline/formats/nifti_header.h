#pragma once
/// The fixed part of a NIfTI header, of either version and byte order. Pure: bytes in, value out.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "pipeline/formats/image_file.h"
#include "pipeline/formats/nifti_geometry.h"
#include "pipeline/formats/voxel_data.h"

namespace beatlas::formats {

/// As many bytes of a file as parse_nifti_header may need (NIfTI-2; NIfTI-1 has 348).
inline constexpr std::size_t kNiftiHeaderBytes = 540;

struct NiftiFields {
  bool big_endian = false;
  bool pair = false;                             ///< voxels in a file of their own (.img)
  std::array<std::int64_t, 4> size{1, 1, 1, 1};  ///< x y z t, each at least 1
  std::array<double, 8> pixdim{};                ///< as it stands
  ScalarType type{};
  std::int64_t offset = 0;  ///< of the voxels in their file, >= 0
  double slope = 1;         ///< never 0, finite
  double intercept = 0;     ///< finite
  int units = 0;            ///< xyzt_units
  int intent = 0;           ///< intent_code
  int sform_code = 0;
  int qform_code = 0;
  std::array<double, 3> quatern{};  ///< b c d
  std::array<double, 3> qoffset{};
  std::array<double, 12> srow{};  ///< row-major 3 x 4
  std::string phantom_identity;   ///< if descrip is a mark (core/phantom_mark.h)
};

/// @throws Error{InvalidInput} with a clause that follows "FILE: ": no NIfTI, Analyze 7.5, colour
///         or complex voxels, more than four dimensions, an image without voxels
[[nodiscard]] NiftiFields parse_nifti_header(std::span<const std::byte> bytes);

/// The orientation fields in mm, by the unit the header names.
[[nodiscard]] NiftiGeometry geometry_of(const NiftiFields& fields);

/// What the header says of its fourth axis.
[[nodiscard]] ImageFileHeader frames_of(const NiftiFields& fields);

}  // namespace beatlas::formats
