#pragma once
#include <cstdint>
#include <vector>

#include <opencv2/core.hpp>

namespace beatlas::report {

/// The bytes of a picture file; grey or, as OpenCV keeps it, blue, green, red, of 8 bits.
/// By VTK: OpenCV's codecs would load a hundred libraries more at every start of the program.
/// @throws Error{Machine}
[[nodiscard]] std::vector<std::uint8_t> png_of(const cv::Mat& picture);
/// @param quality 0..100
[[nodiscard]] std::vector<std::uint8_t> jpeg_of(const cv::Mat& picture, int quality);

}  // namespace beatlas::report
