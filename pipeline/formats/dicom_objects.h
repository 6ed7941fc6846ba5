#pragma once
/// What the DICOM writers share; not for other rooms.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include <vtkDICOMMetaData.h>

#include "pipeline/core/exam.h"
#include "pipeline/formats/dicom_writer.h"

namespace beatlas::formats {

/// The most digits of `value` that fit a DICOM decimal string.
[[nodiscard]] std::string decimal_string(double value);
[[nodiscard]] std::string decimal_strings(std::initializer_list<double> values);

/// 2.25.<decimal of the first 128 bits of the SHA-256 of `text`> (DICOM PS3.5 B.2).
[[nodiscard]] std::string uid_of(const std::string& text);

/// Voxels rounded to 16-bit words, the same for signed and unsigned.
[[nodiscard]] std::vector<std::uint16_t> words(std::span<const float> values);

struct Range {
  long low = 0;
  long high = 0;
};
/// Of all voxels. @throws Error{InvalidInput} if they do not fit 16 bit.
[[nodiscard]] Range range_of(const Cine& cine);

/// @throws Error{InvalidInput} if DICOM cannot hold the cine.
void check_cine(const Cine& cine);

/// Content of the cine as text: hashes of its images, its geometry and time.
[[nodiscard]] std::string content_of(const Cine& cine);

/// Patient, study, series and the pixels' format: what every object of a cine has.
void set_common(vtkDICOMMetaData& meta, const Cine& cine, const Range& range,
                const DicomWriteOptions& options, const std::string& content);

/// Direction cosines of row and column; row and column spacing; of a slice's first voxel.
[[nodiscard]] std::string orientation_of(const Grid& grid);
[[nodiscard]] std::string pixel_spacing_of(const Grid& grid);
[[nodiscard]] std::string position_of(const Grid& grid, int slice);

/// Writes one object with frame after frame of `pixels`; UIDs are taken from `meta`.
/// @throws Error{Machine}
void write_object(const std::filesystem::path& file, vtkDICOMMetaData& meta, int frames,
                  const std::function<std::vector<std::uint16_t>(int)>& pixels);

}  // namespace beatlas::formats
