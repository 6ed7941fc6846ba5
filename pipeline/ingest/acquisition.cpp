#include "pipeline/ingest/acquisition.h"

#include <algorithm>
#include <cmath>

namespace beatlas::ingest {
namespace {

// Shares of the larger of two values.
constexpr double kTrimmedEcho = 0.1;
constexpr double kTrimmedFlip = 1.0 / 3;
constexpr double kPlannedEcho = 1.0 / 3;
constexpr double kPlannedFlip = 0.5;
// Ratio of R-R intervals: from breath-hold to breath-hold they differ by some per cent, stress
// agents shorten them by a quarter and more.
constexpr double kOneRate = 1.15;

bool agree(double a, double b, double share) {
  return std::abs(a - b) <= share * std::max(std::abs(a), std::abs(b));
}

bool alike(const Contrast& a, const Contrast& b, double echo_share, double flip_share) {
  const bool one_family = a.family.empty() || b.family.empty() || a.family == b.family;
  const bool one_flip =
      a.flip_deg <= 0 || b.flip_deg <= 0 || agree(a.flip_deg, b.flip_deg, flip_share);
  return a.sequence == b.sequence && one_family && one_flip &&
         (a.inversion_ms > 0) == (b.inversion_ms > 0) && agree(a.echo_ms, b.echo_ms, echo_share);
}

}  // namespace

bool same_contrast(const Contrast& a, const Contrast& b) {
  return alike(a, b, kTrimmedEcho, kTrimmedFlip);
}

bool one_protocol(const Contrast& a, const Contrast& b) {
  return alike(a, b, kPlannedEcho, kPlannedFlip);
}

bool is_spoiled(const Contrast& contrast) {
  const auto variant = contrast.sequence.find('\n');
  if (variant == std::string::npos) return false;
  // Values are parted by backslashes; "OSP" is another.
  const std::string values = '\\' + contrast.sequence.substr(variant + 1) + '\\';
  return values.find("\\SP\\") != std::string::npos;
}

bool same_rate(double a_s, double b_s) {
  return a_s <= 0 || b_s <= 0 || std::max(a_s, b_s) <= kOneRate * std::min(a_s, b_s);
}

bool same_frame(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() || a == b;
}

}  // namespace beatlas::ingest
