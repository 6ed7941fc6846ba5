#pragma once
/// Image files written byte by byte, after the formats' own descriptions and not with our readers'
/// code, of an object that no flip or swap of axes maps onto itself.

#include <algorithm>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/core/grid.h"

namespace beatlas::test {

/// A beating object in closed form, seen on an oblique grid.
struct Beating {
  Grid grid;
  int frames = 10;

  /// Brightness at a place of the patient, 100..4000.
  [[nodiscard]] double value(const Vec3& lps, int frame) const;
  /// Whole numbers of all voxels, i fastest, then j, k, frame.
  [[nodiscard]] std::vector<double> voxels() const;
};

/// 20 x 16 x 6 voxels of 4.0 x 4.5 x 8.0 mm, three angles.
[[nodiscard]] Beating oblique_object(bool left_handed = false);

/// Numbers as stored: "i1 u1 i2 u2 i4 u4 i8 u8 f4 f8", or "text".
[[nodiscard]] std::string stored(const std::vector<double>& values, const std::string& type,
                                 bool big_endian = false);

/// The frame axis of [frame][voxel] numbers put first.
[[nodiscard]] std::vector<double> frames_first(const std::vector<double>& values, int frames);

[[nodiscard]] std::string gzip(const std::string& bytes);
[[nodiscard]] std::string zlib(const std::string& bytes);
[[nodiscard]] std::string bzip2(const std::string& bytes);

struct NiftiForm {
  int version = 1;
  bool big_endian = false;
  bool pair = false;
  std::string type = "i2";
  int units = 2 | 8;  ///< mm, s
  double interval = 0.09;
  double slope = 0;
  double intercept = 0;
  bool sform = true;
  bool qform = true;
  /// Changes the header before it is written: bytes, and a setter of a number at a place.
  std::function<void(std::string&)> change = {};
};
/// Header and its mark (of a pair: header alone).
[[nodiscard]] std::string nifti_header(const Grid& grid, int frames, const NiftiForm& form);

/// "(x,y,z)" of an axis of the grid in a space whose x and y have these signs against LPS.
[[nodiscard]] std::string nrrd_vector(const Vec3& lps, double x_sign = 1, double y_sign = 1);
/// Lines of a NRRD header without its end; frame axis last or first.
[[nodiscard]] std::string nrrd_header(const Grid& grid, int frames, bool first = false,
                                      const std::string& space = "left-posterior-superior",
                                      const std::string& type = "short");
/// Lines of a MetaImage header without ElementDataFile; 3-D for one frame.
[[nodiscard]] std::string meta_header(const Grid& grid, int frames,
                                      const std::string& type = "MET_SHORT",
                                      double interval = 0.09);

template <class T>
void put(std::string& bytes, std::size_t at, T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  std::copy(raw, raw + sizeof(T), bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

}  // namespace beatlas::test
