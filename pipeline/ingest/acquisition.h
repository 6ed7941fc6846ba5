#pragma once
/// What tells the acquisitions of an exam apart. Whatever keeps images apart, or ranks them by what
/// they are, asks here: image sets of a place, possible stacks, guests and views.

#include <string>

namespace beatlas::ingest {

/// What an image was made from, the best last: ImageType, BurnedInAnnotation and SOP class (PS3.3
/// C.7.6.1.1.2, C.7.6.1.1).
enum class Provenance {
  Secondary,  ///< a screenshot or a copy that was drawn on
  Derived,    ///< calculated from other images, of the patient all the same (DERIVED\PRIMARY)
  Original,   ///< as acquired, or it does not say
};

/// By which pulse sequence tissue looks as it does.
struct Contrast {
  std::string sequence = {};  ///< ScanningSequence and SequenceVariant; never shown
  std::string family = {};    ///< the letters of SequenceName, "tfi" of "*tfi2d1_10"; never shown
  double echo_ms = 0;         ///< EchoTime
  double inversion_ms = 0;    ///< 0: no inversion
  double flip_deg = 0;        ///< 0: not told

  bool operator==(const Contrast&) const = default;
};

/// Whether slices of both may be of one stack: scanners trim echo times and flip angles slice by
/// slice, by less than a tenth and a third.
[[nodiscard]] bool same_contrast(const Contrast& a, const Contrast& b);

/// Whether both are of one protocol, though planned in several directions: other fields of view and
/// matrices change the echo time by up to a third, limits of heating the flip angle by up to half.
[[nodiscard]] bool one_protocol(const Contrast& a, const Contrast& b);

/// Spoiled (SequenceVariant SP), as tagging and flow are; cines for volumes are mostly not (Kramer
/// et al., J Cardiovasc Magn Reson 2020;22:17, doi:10.1186/s12968-020-00607-1).
[[nodiscard]] bool is_spoiled(const Contrast& contrast);

/// Whether two R-R intervals [s] are of one state of the heart, not rest and stress; 0, which is
/// unknown, is of any.
[[nodiscard]] bool same_rate(double a_s, double b_s);

/// Whether places of both UIDs of frames of reference can be compared; an empty one, which is
/// unknown, goes with any.
[[nodiscard]] bool same_frame(const std::string& a, const std::string& b);

}  // namespace beatlas::ingest
