#include "tests/unit/formats/image_bytes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include <bzlib.h>
#include <zlib.h>

namespace beatlas::test {
namespace {

template <class T>
std::string as(const std::vector<double>& values, bool big_endian) {
  std::string out(values.size() * sizeof(T), '\0');
  for (std::size_t i = 0; i < values.size(); ++i) {
    put(out, i * sizeof(T), static_cast<T>(values[i]), big_endian);
  }
  return out;
}

std::string deflated(const std::string& bytes, int window) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, window, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, bytes.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  if (deflate(&stream, Z_FINISH) != Z_STREAM_END) throw std::runtime_error("deflate");
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

int nifti_type(const std::string& type) {
  const std::pair<const char*, int> codes[] = {{"u1", 2},    {"i2", 4},   {"i4", 8},   {"f4", 16},
                                               {"f8", 64},   {"i1", 256}, {"u2", 512}, {"u4", 768},
                                               {"i8", 1024}, {"u8", 1280}};
  for (const auto& [name, code] : codes) {
    if (type == name) return code;
  }
  return 0;
}

/// x and y turned round: what NIfTI calls the same place.
Affine ras(const Affine& lps) {
  Affine out = lps;
  out.matrix().topRows<2>() *= -1;
  return out;
}

}  // namespace

double Beating::value(const Vec3& lps, int frame) const {
  struct Blob {
    Vec3 local;
    double sigma, height;
  };
  const Blob blobs[] = {{{20, 45, 14}, 9, 2000}, {{60, 20, 30}, 8, 1500}, {{38, 55, 34}, 7, 1000}};
  const Vec3 spacing = grid.spacing_mm();
  double out = 100;
  for (const Blob& blob : blobs) {
    const Vec3 centre = grid.mm(blob.local.x() / spacing.x(), blob.local.y() / spacing.y(),
                                blob.local.z() / spacing.z());
    out += blob.height * std::exp(-(lps - centre).squaredNorm() / (2 * blob.sigma * blob.sigma));
  }
  return out * (1 + 0.3 * std::cos(2 * std::numbers::pi * frame / frames));
}

std::vector<double> Beating::voxels() const {
  std::vector<double> out;
  for (int p = 0; p < frames; ++p) {
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          out.push_back(std::round(value(grid.mm(i, j, k), p)));
        }
      }
    }
  }
  return out;
}

Beating oblique_object(bool left_handed) {
  Beating out;
  out.grid.size = {20, 16, 6};
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(0.8, Vec3::UnitZ()) * Eigen::AngleAxisd(-0.35, Vec3::UnitY()) *
       Eigen::AngleAxisd(0.5, Vec3::UnitX()))
          .toRotationMatrix();
  out.grid.mm_from_index.linear() = turn * Vec3(4.0, 4.5, left_handed ? -8.0 : 8.0).asDiagonal();
  out.grid.mm_from_index.translation() = Vec3(-100.25, -60.5, 20.125);
  return out;
}

std::string stored(const std::vector<double>& values, const std::string& type, bool big_endian) {
  if (type == "i1") return as<std::int8_t>(values, big_endian);
  if (type == "u1") return as<std::uint8_t>(values, big_endian);
  if (type == "i2") return as<std::int16_t>(values, big_endian);
  if (type == "u2") return as<std::uint16_t>(values, big_endian);
  if (type == "i4") return as<std::int32_t>(values, big_endian);
  if (type == "u4") return as<std::uint32_t>(values, big_endian);
  if (type == "i8") return as<std::int64_t>(values, big_endian);
  if (type == "u8") return as<std::uint64_t>(values, big_endian);
  if (type == "f4") return as<float>(values, big_endian);
  if (type == "f8") return as<double>(values, big_endian);
  std::ostringstream text;
  for (const double value : values) text << value << '\n';
  return text.str();
}

std::vector<double> frames_first(const std::vector<double>& values, int frames) {
  const std::size_t count = values.size() / static_cast<std::size_t>(frames);
  std::vector<double> out;
  for (std::size_t v = 0; v < count; ++v) {
    for (std::size_t p = 0; p < static_cast<std::size_t>(frames); ++p) {
      out.push_back(values[p * count + v]);
    }
  }
  return out;
}

std::string gzip(const std::string& bytes) { return deflated(bytes, 15 + 16); }
std::string zlib(const std::string& bytes) { return deflated(bytes, 15); }
std::string bzip2(const std::string& bytes) {
  std::string out(bytes.size() + bytes.size() / 100 + 600, '\0');
  auto size = static_cast<unsigned>(out.size());
  if (BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(bytes.data()),
                               static_cast<unsigned>(bytes.size()), 9, 0, 0) != BZ_OK) {
    throw std::runtime_error("bzip2");
  }
  out.resize(size);
  return out;
}

std::string nifti_header(const Grid& grid, int frames, const NiftiForm& form) {
  const bool one = form.version == 1;
  std::string out(one ? 348 : 540, '\0');
  const auto i16 = [&](std::size_t at, int v) {
    put(out, at, static_cast<std::int16_t>(v), form.big_endian);
  };
  const auto i32 = [&](std::size_t at, int v) {
    put(out, at, static_cast<std::int32_t>(v), form.big_endian);
  };
  const auto real = [&](std::size_t at, double v) {
    if (one) put(out, at, static_cast<float>(v), form.big_endian);
    if (!one) put(out, at, v, form.big_endian);
  };
  const std::size_t width = one ? 4 : 8;  // of a real number
  i32(0, static_cast<int>(out.size()));
  const int dim[] = {frames > 1 ? 4 : 3, grid.size[0], grid.size[1], grid.size[2], frames, 1, 1, 1};
  for (std::size_t d = 0; d < 8; ++d) {
    if (one) i16(40 + 2 * d, dim[d]);
    if (!one) put(out, 16 + 8 * d, static_cast<std::int64_t>(dim[d]), form.big_endian);
  }
  const std::size_t bits = form.type.empty() ? 0 : 8 * static_cast<std::size_t>(form.type[1] - '0');
  i16(one ? 70 : 12, nifti_type(form.type));
  i16(one ? 72 : 14, static_cast<int>(bits));

  const Affine affine = ras(grid.mm_from_index);
  Eigen::Matrix3d turn = affine.linear().colwise().normalized();
  const double handed = turn.determinant() < 0 ? -1 : 1;
  turn.col(2) *= handed;
  Eigen::Quaterniond q(turn);
  if (q.w() < 0) q.coeffs() *= -1;
  const Vec3 spacing = grid.spacing_mm();
  const double pixdim[] = {handed, spacing.x(), spacing.y(), spacing.z(), form.interval, 1, 1, 1};
  for (std::size_t d = 0; d < 8; ++d) real((one ? 76 : 104) + width * d, pixdim[d]);
  const double offset = form.pair ? 0 : static_cast<double>(out.size()) + 4;
  if (one) real(108, offset);
  if (!one) put(out, 168, static_cast<std::int64_t>(offset), form.big_endian);
  real(one ? 112 : 176, form.slope);
  real(one ? 116 : 184, form.intercept);
  if (one) out[123] = static_cast<char>(form.units);
  if (!one) i32(500, form.units);
  one ? i16(252, form.qform) : i32(344, form.qform);
  one ? i16(254, form.sform) : i32(348, form.sform);
  const Vec3 place = affine.translation();
  const double quatern[] = {q.x(), q.y(), q.z(), place.x(), place.y(), place.z()};
  for (std::size_t i = 0; i < 6; ++i) real((one ? 256 : 352) + width * i, quatern[i]);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) {
      real((one ? 280 : 400) + width * static_cast<std::size_t>(4 * r + c), affine.matrix()(r, c));
    }
  }
  char magic[4] = "n+1";
  if (form.pair) magic[1] = 'i';
  if (!one) magic[2] = '2';
  std::copy_n(magic, 3, out.begin() + (one ? 344 : 4));
  if (form.change) form.change(out);
  if (!form.pair) out.append(4, '\0');
  return out;
}

std::string nrrd_vector(const Vec3& lps, double x_sign, double y_sign) {
  std::ostringstream out;
  out.precision(15);
  out << '(' << lps.x() * x_sign << ',' << lps.y() * y_sign << ',' << lps.z() << ')';
  return out.str();
}

std::string nrrd_header(const Grid& grid, int frames, bool first, const std::string& space,
                        const std::string& type) {
  const bool ras_x = space.starts_with("right") || space.starts_with("RAS");
  const bool ras_y = ras_x || space.starts_with("left-anterior") || space.starts_with("LAS");
  const auto vector = [&](const Vec3& lps) {
    return nrrd_vector(lps, ras_x ? -1 : 1, ras_y ? -1 : 1);
  };
  std::ostringstream directions;
  std::ostringstream sizes;
  if (frames > 1 && first) {
    directions << " none";
    sizes << ' ' << frames;
  }
  for (int axis = 0; axis < 3; ++axis) {
    directions << ' ' << vector(grid.mm_from_index.linear().col(axis));
    sizes << ' ' << grid.size[static_cast<std::size_t>(axis)];
  }
  if (frames > 1 && !first) {
    directions << " none";
    sizes << ' ' << frames;
  }
  std::ostringstream out;
  out << "NRRD0004\n# by hand\ntype: " << type << "\ndimension: " << (frames > 1 ? 4 : 3)
      << "\nspace: " << space << "\nsizes:" << sizes.str()
      << "\nspace directions:" << directions.str()
      << "\nspace origin: " << vector(grid.mm_from_index.translation()) << "\nendian: little\n";
  return out.str();
}

std::string meta_header(const Grid& grid, int frames, const std::string& type, double interval) {
  const int dimension = frames > 1 ? 4 : 3;
  std::ostringstream out;
  out.precision(15);
  out << "ObjectType = Image\nNDims = " << dimension << "\nBinaryData = True\nTransformMatrix =";
  const Vec3 spacing = grid.spacing_mm();
  for (int axis = 0; axis < dimension; ++axis) {
    for (int r = 0; r < dimension; ++r) {
      const bool space = axis < 3 && r < 3;
      out << ' ' << (space ? grid.mm_from_index.linear()(r, axis) / spacing[axis] : axis == r);
    }
  }
  const Vec3 place = grid.mm_from_index.translation();
  out << "\nOffset = " << place.x() << ' ' << place.y() << ' ' << place.z();
  if (dimension == 4) out << " 0";
  out << "\nElementSpacing = " << spacing.x() << ' ' << spacing.y() << ' ' << spacing.z();
  if (dimension == 4) out << ' ' << interval;
  out << "\nDimSize = " << grid.size[0] << ' ' << grid.size[1] << ' ' << grid.size[2];
  if (dimension == 4) out << ' ' << frames;
  out << "\nElementType = " << type << '\n';
  return out.str();
}

}  // namespace beatlas::test
