#pragma once
/// Pieces of SVG that every plot is made of. Lengths in pixels.

#include <array>
#include <string>

namespace beatlas::plot {

/// Of Okabe and Ito, which the colour-blind tell apart; grey for the last.
inline constexpr std::array<const char*, 8> kColours{"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                     "#56B4E9", "#E69F00", "#000000", "#7A7A7A"};

/// Words as the text of SVG and HTML.
[[nodiscard]] std::string escaped(const std::string& words);
/// With one digit after the point.
[[nodiscard]] std::string pixels(double value);
/// As short as six digits allow.
[[nodiscard]] std::string shortest(double value);

/// @param anchor "start", "middle" or "end"  @param more further attributes, with a space before
[[nodiscard]] std::string text_at(double x, double y, const std::string& anchor,
                                  const std::string& words, const std::string& more = "");
/// @param style attributes
[[nodiscard]] std::string line(double x1, double y1, double x2, double y2,
                               const std::string& style);
/// An SVG up to its white background; "</svg>\n" ends it.
[[nodiscard]] std::string svg_head(double width, double height);

/// 1, 2 or 5 times a power of ten that cuts `range` into at most `most` parts. @pre range > 0
[[nodiscard]] double round_step(double range, int most);

}  // namespace beatlas::plot
