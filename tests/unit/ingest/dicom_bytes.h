#pragma once
/// DICOM files written byte by byte after the standard (PS3.5, PS3.10), not with our readers' code.

#include <string>
#include <vector>

namespace beatlas::test {

inline constexpr const char* kImplicit = "1.2.840.10008.1.2";
inline constexpr const char* kExplicit = "1.2.840.10008.1.2.1";
inline constexpr const char* kBigEndian = "1.2.840.10008.1.2.2";
inline constexpr const char* kDeflated = "1.2.840.10008.1.2.1.99";
inline constexpr const char* kJpeg = "1.2.840.10008.1.2.4.51";  // extended, 8 and 12 bits
inline constexpr const char* kJpegLossless = "1.2.840.10008.1.2.4.70";
inline constexpr const char* kJpegLs = "1.2.840.10008.1.2.4.80";
inline constexpr const char* kJpeg2000 = "1.2.840.10008.1.2.4.90";
inline constexpr const char* kRunLengths = "1.2.840.10008.1.2.5";

/// An MR image; what its header says need not be so.
struct DicomForm {
  std::string syntax = kExplicit;
  int columns = 4;
  int rows = 3;
  int frames = 1;  ///< told unless it is 1
  int bits = 16;   ///< 8 or 16, all stored
  int instance = 1;
  double slice_mm = 0;  ///< place along z
  double trigger_ms = 0;
  std::string pixels = std::string(24, '\x01');  ///< of plain images, as stored
  std::vector<std::string> fragments = {};       ///< of packed ones
  std::string behind = {};                       ///< elements behind the pixels, as stored
};
[[nodiscard]] std::string dicom_file(const DicomForm& form);

/// What lies behind the head of such a file, before it is deflated; and the head put before that.
[[nodiscard]] std::string data_set(const DicomForm& form);
[[nodiscard]] std::string with_head(const std::string& syntax, std::string data_set,
                                    int instance = 1);

/// PackBits of one plane of bytes, as PS3.5 G wants it, for 8 bits a pixel.
[[nodiscard]] std::string run_lengths(const std::string& bytes);

}  // namespace beatlas::test
