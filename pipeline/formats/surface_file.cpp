#include "pipeline/formats/surface_file.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <tuple>

#include "runtime/base/error.h"

namespace beatlas::formats {
namespace {

constexpr std::size_t kMost = 20'000'000;
constexpr std::size_t kStlHead = 84;
constexpr std::size_t kStlTriangle = 50;

std::string read_whole(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw_invalid("it cannot be read; check its name and rights");
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string_view next_word(std::string_view& line) {
  const std::size_t begin = line.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return line = {};
  line.remove_prefix(begin);
  const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(end);
  return word;
}

Vec3 read_point(std::string_view rest, std::size_t line) {
  Vec3 out;
  for (double& value : out) {
    std::string_view word = next_word(rest);
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
      throw_invalid("line " + std::to_string(line) + ": a point needs three finite numbers");
    }
  }
  return out;
}

/// Calls visit(line, number) for each line.
template <class Visit>
void each_line(std::string_view text, Visit visit) {
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    visit(text.substr(0, end), number);
    if (end == std::string_view::npos) return;
    text.remove_prefix(end + 1);
  }
}

void check_size(const SurfaceMesh& mesh) {
  if (mesh.points.size() > kMost || mesh.triangles.size() > kMost) {
    throw_invalid("it has more than 20 million points or triangles; make it coarser");
  }
}

SurfaceMesh checked(SurfaceMesh mesh) {
  if (mesh.triangles.empty()) throw_invalid("it holds no triangles");
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) {
      if (corner >= mesh.points.size()) {
        throw_invalid("a face names point " + std::to_string(corner + std::uint64_t{1}) + " of " +
                      std::to_string(mesh.points.size()));
      }
    }
  }
  return mesh;
}

SurfaceMesh obj_from_text(std::string_view text) {
  SurfaceMesh mesh;
  each_line(text, [&](std::string_view line, std::size_t number) {
    const std::string_view kind = next_word(line);
    if (kind == "v") {
      mesh.points.push_back(read_point(line, number));
    } else if (kind == "f") {
      std::vector<std::uint32_t> corners;
      for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
        long index = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), index);
        // Below 0 it counts from the newest point.
        const auto points = static_cast<long>(mesh.points.size());
        const long corner = index < 0 ? points + index : index - 1;
        if (error != std::errc() || (end != word.data() + word.size() && *end != '/') ||
            corner < 0 || corner >= static_cast<long>(kMost)) {
          throw_invalid("line " + std::to_string(number) + ": a face names no point there is");
        }
        corners.push_back(static_cast<std::uint32_t>(corner));
      }
      if (corners.size() < 3) {
        throw_invalid("line " + std::to_string(number) + ": a face needs three points");
      }
      for (std::size_t n = 2; n < corners.size(); ++n) {
        mesh.triangles.push_back({corners[0], corners[n - 1], corners[n]});
      }
    }
    check_size(mesh);
  });
  return mesh;
}

/// One point for all corners at one place.
class Welder {
 public:
  std::uint32_t point(const Vec3& at) {
    const auto [found, fresh] = known_.try_emplace(std::tuple(at.x(), at.y(), at.z()),
                                                   static_cast<std::uint32_t>(mesh.points.size()));
    if (fresh) mesh.points.push_back(at);
    return found->second;
  }
  void add(const std::array<Vec3, 3>& corners) {
    const std::array<std::uint32_t, 3> triangle{point(corners[0]), point(corners[1]),
                                                point(corners[2])};
    // One that is a line has nothing on either side.
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) {
      return;
    }
    mesh.triangles.push_back(triangle);
    check_size(mesh);
  }
  SurfaceMesh mesh;

 private:
  std::map<std::tuple<double, double, double>, std::uint32_t> known_;
};

SurfaceMesh stl_from_bytes(std::string_view bytes, std::size_t count) {
  Welder welder;
  for (std::size_t n = 0; n < count; ++n) {
    std::array<float, 9> numbers;  // after the normal
    std::memcpy(numbers.data(), bytes.data() + kStlHead + kStlTriangle * n + 12, sizeof numbers);
    std::array<Vec3, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) {
      corners[c] = Vec3(numbers[3 * c], numbers[3 * c + 1], numbers[3 * c + 2]);
      if (!corners[c].allFinite()) {
        throw_invalid("triangle " + std::to_string(n + 1) + " has a corner that is no place");
      }
    }
    welder.add(corners);
  }
  return std::move(welder.mesh);
}

SurfaceMesh stl_from_text(std::string_view text) {
  Welder welder;
  std::array<Vec3, 3> corners;
  std::size_t found = 0;
  each_line(text, [&](std::string_view line, std::size_t number) {
    const std::string_view kind = next_word(line);
    if (kind == "vertex") {
      if (found == 3) throw_invalid("line " + std::to_string(number) + ": a facet of four corners");
      corners[found++] = read_point(line, number);
    } else if (kind == "endfacet") {
      if (found != 3) {
        throw_invalid("line " + std::to_string(number) + ": a facet without three corners");
      }
      welder.add(corners);
      found = 0;
    }
  });
  if (found != 0) throw_invalid("it ends within a facet");
  return std::move(welder.mesh);
}

template <class Read>
SurfaceMesh read_surface(const std::filesystem::path& file, Read read) {
  try {
    return checked(read(read_whole(file)));
  } catch (const Error& error) {
    throw error.with_context(file.string());
  }
}

}  // namespace

SurfaceMesh read_obj(const std::filesystem::path& file) {
  return read_surface(file, [](const std::string& text) { return obj_from_text(text); });
}

SurfaceMesh read_stl(const std::filesystem::path& file) {
  return read_surface(file, [](const std::string& bytes) {
    // Some binary ones begin with "solid" as well: their size tells.
    if (bytes.size() >= kStlHead) {
      std::uint32_t count = 0;
      std::memcpy(&count, bytes.data() + kStlHead - 4, sizeof count);
      if (bytes.size() == kStlHead + kStlTriangle * std::size_t{count}) {
        if (count > kMost) throw_invalid("it has more than 20 million triangles; make it coarser");
        return stl_from_bytes(bytes, count);
      }
    }
    if (!bytes.starts_with("solid")) throw_invalid("it is no STL file, or it is cut short");
    return stl_from_text(bytes);
  });
}

}  // namespace beatlas::formats
