#include "pipeline/phantom/spec.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/phantom/heart_shape.h"
#include "pipeline/phantom/json_vector.h"

namespace beatlas::phantom {
namespace {

/// Largest n . x over an ellipsoid below a plane: at the ellipsoid's own extreme, or on the rim.
double support(const Ellipsoid& e, double cut_z_mm, const Vec3& n) {
  const Vec3 scaled = e.semi_axes_mm.cwiseProduct(n);
  const Vec3 extreme = e.centre_mm + e.semi_axes_mm.cwiseProduct(scaled) / scaled.norm();
  Ellipse rim;
  if (extreme.z() <= cut_z_mm || !section(e, cut_z_mm, rim)) return n.dot(extreme);
  return n.dot(rim.centre_mm) + std::hypot(rim.semi_x_mm * n.x(), rim.semi_y_mm * n.y());
}

/// The ventricles must lie within the images; atria and aorta may leave them, as in short-axis
/// stacks.
void check_view(const PhantomSpec& spec) {
  const Grid grid = spec.imaging_grid();
  const Affine index_from_heart = grid.mm_from_index.inverse() * lps_from_heart(spec.anatomy);
  constexpr int kMoments = 10;  // every extreme moves monotonically with s but for the solved wall
  for (int moment = 0; moment <= kMoments; ++moment) {
    const HeartShape shape = heart_shape(spec.anatomy, static_cast<double>(moment) / kMoments);
    for (int axis = 0; axis < 3; ++axis) {
      for (double sign : {-1.0, 1.0}) {
        const Vec3 row = sign * index_from_heart.linear().row(axis).transpose();
        double reach = std::max(support(shape.lv_epicardium, shape.lv_base_z_mm, row),
                                support(shape.rv_outer, shape.rv_cut_z_mm, row));
        if (shape.infarct) {
          const Ellipsoid& still = shape.infarct->epicardium;
          reach = std::max(reach, support(still, shape.lv_base_z_mm, row));
        }
        reach += sign * index_from_heart.translation()[axis];
        const double end = sign > 0 ? grid.size[axis] - 0.5 : 0.5;
        if (reach > end) {
          throw_invalid("the phantom's ventricles leave the field of view along index " +
                        std::string(1, "ijk"[axis]) +
                        "; move /anatomy/origin_lps_mm, lower /anatomy/scale or widen /grid");
        }
      }
    }
  }
}

void check_range(const std::string& key, double value, double low, double high) {
  if (!(value >= low && value <= high)) {
    throw_invalid("/" + key + " must be a number from " + nlohmann::json(low).dump() + " to " +
                  nlohmann::json(high).dump());
  }
}

Affine centred(const Vec3& spacing_mm, const Index3& size, const Vec3& centre) {
  Affine out = Affine::Identity();
  out.linear() = spacing_mm.asDiagonal();
  out.translation() =
      centre - spacing_mm.cwiseProduct(0.5 * Vec3(size[0] - 1, size[1] - 1, size[2] - 1));
  return out;
}

}  // namespace

Grid PhantomSpec::imaging_grid() const {
  constexpr double kRadians = std::numbers::pi / 180.0;
  Grid out = grid;
  if (oblique_deg.isZero(0.0)) return out;
  const Vec3 centre =
      grid.mm(0.5 * (grid.size[0] - 1), 0.5 * (grid.size[1] - 1), 0.5 * (grid.size[2] - 1));
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(oblique_deg.z() * kRadians, Vec3::UnitZ()) *
                                Eigen::AngleAxisd(oblique_deg.y() * kRadians, Vec3::UnitY()) *
                                Eigen::AngleAxisd(oblique_deg.x() * kRadians, Vec3::UnitX()))
                                   .toRotationMatrix();
  out.mm_from_index.linear() = turn * grid.mm_from_index.linear();
  out.mm_from_index.translation() = centre + turn * (grid.mm_from_index.translation() - centre);
  return out;
}

Grid on_matrix(const Grid& grid, const Index3& size, const Vec3& spacing_mm) {
  const Vec3 spacing = grid.spacing_mm();
  Grid out = grid;
  Vec3 wanted = spacing;
  for (int a = 0; a < 3; ++a) {
    const double field_mm = grid.size[a] * spacing[a];
    if (spacing_mm[a] > 0.0) wanted[a] = spacing_mm[a];
    if (size[a] > 0) {
      out.size[a] = size[a];
      if (!(spacing_mm[a] > 0.0)) wanted[a] = field_mm / size[a];
    } else {
      out.size[a] = std::max(1, static_cast<int>(std::lround(field_mm / wanted[a])));
    }
  }
  const Vec3 centre =
      grid.mm(0.5 * (grid.size[0] - 1), 0.5 * (grid.size[1] - 1), 0.5 * (grid.size[2] - 1));
  out.mm_from_index.linear() =
      grid.mm_from_index.linear() * wanted.cwiseQuotient(spacing).asDiagonal();
  out.mm_from_index.translation() =
      centre -
      out.mm_from_index.linear() * (0.5 * Vec3(out.size[0] - 1, out.size[1] - 1, out.size[2] - 1));
  return out;
}

void check_spec(const PhantomSpec& spec) {
  check_range("phases", spec.phases, 2, 200);
  check_range("rr_interval_s", spec.rr_interval_s, 0.2, 3.0);
  check_range("anatomy/scale", spec.anatomy.scale, 0.3, 1.6);
  for (int axis = 0; axis < 3; ++axis) check_range("grid/size", spec.grid.size[axis], 1, 1024);
  check_scanner(spec.scanner, spec.grid.size[2]);
  const Vec3 spacing = spec.grid.spacing_mm();
  const Eigen::Matrix3d axes = spec.grid.mm_from_index.linear();
  for (int axis = 0; axis < 3; ++axis) {
    check_range("grid/lps_from_index (spacing)", spacing[axis], 0.2, 30.0);
    const int next = (axis + 1) % 3;
    if (std::abs(axes.col(axis).dot(axes.col(next))) > 1e-9 * spacing[axis] * spacing[next]) {
      throw_invalid("/grid/lps_from_index must have perpendicular axes");
    }
  }
  if (spec.grid.count() * static_cast<std::size_t>(spec.phases) > std::size_t{1} << 30) {
    throw_invalid("/grid/size times /phases is more than 2^30 voxels; make the phantom smaller");
  }
  check_anatomy(spec.anatomy);
  check_view(spec);
}

nlohmann::json spec_to_json(const PhantomSpec& spec) {
  nlohmann::json matrix = nlohmann::json::array();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      matrix.push_back(spec.grid.mm_from_index.matrix()(row, column));
    }
  }
  return {{"name", spec.name},
          {"grid", {{"size", spec.grid.size}, {"lps_from_index", matrix}}},
          {"oblique_deg", to_json(spec.oblique_deg)},
          {"phases", spec.phases},
          {"rr_interval_s", spec.rr_interval_s},
          {"scanner", scanner_to_json(spec.scanner)},
          {"anatomy", anatomy_to_json(spec.anatomy)}};
}

PhantomSpec spec_from_json(const nlohmann::json& json) {
  PhantomSpec spec;
  JsonObject object(json, "");
  object.read("name", spec.name);
  JsonObject grid(object.at("grid"), "/grid");
  const nlohmann::json& size = grid.at("size");
  const nlohmann::json& matrix = grid.at("lps_from_index");
  bool good = size.is_array() && size.size() == 3 && matrix.is_array() && matrix.size() == 16;
  for (std::size_t n = 0; good && n < 3; ++n) {
    good =
        size[n].is_number_integer() && size[n].get<double>() >= 1 && size[n].get<double>() <= 1024;
    if (good) spec.grid.size[n] = size[n].get<int>();
  }
  for (std::size_t n = 0; good && n < 16; ++n) {
    good = matrix[n].is_number() && (n < 12 || matrix[n].get<double>() == (n == 15 ? 1.0 : 0.0));
    if (good) {
      spec.grid.mm_from_index.matrix()(static_cast<int>(n) / 4, static_cast<int>(n) % 4) =
          matrix[n].get<double>();
    }
  }
  if (!good) {
    throw_invalid(
        "/grid must have size (3 whole numbers from 1 to 1024) and lps_from_index (16 "
        "numbers, row-major, last row 0 0 0 1)");
  }
  grid.finish();
  read_vector(object, "oblique_deg", spec.oblique_deg, -180.0, 180.0);
  object.read("phases", spec.phases, 2, 200);
  object.read("rr_interval_s", spec.rr_interval_s, 0.2, 3.0);
  if (object.has("scanner")) spec.scanner = scanner_from_json(object.at("scanner"), "/scanner");
  if (object.has("anatomy")) spec.anatomy = anatomy_from_json(object.at("anatomy"), "/anatomy");
  object.finish();
  check_spec(spec);
  return spec;
}

std::vector<std::string> preset_names() {
  return {"adult", "small", "clinical", "infarct", "hard"};
}

PhantomSpec preset(const std::string& name) {
  constexpr double kLiverInTouchMm = 20.0;  // it then indents the heart's lower side at rest
  PhantomSpec spec;
  spec.name = name;
  spec.scanner.snr_blood = 20.0;
  if (name == "adult" || name == "infarct" || name == "hard") {
    spec.grid.size = {256, 256, 64};
    spec.grid.mm_from_index = centred({1.0, 1.0, 3.0}, spec.grid.size, Vec3::Zero());
    if (name == "infarct") spec.anatomy.infarct.present = true;
    if (name == "hard") {
      spec.anatomy.liver_rise_mm = kLiverInTouchMm;
      spec.scanner.signals = "A";
      spec.scanner.snr_blood = 10.0;
      spec.scanner.bias_share = 0.5;
      spec.scanner.shift_sigma_mm = 2.0;
    }
  } else if (name == "small") {
    spec.phases = 10;
    spec.grid.size = {88, 88, 44};
    spec.grid.mm_from_index = centred({2.0, 2.0, 4.0}, spec.grid.size, {0.0, 0.0, 0.0});
  } else if (name == "clinical") {
    spec.phases = 25;
    spec.rr_interval_s = 0.9;
    spec.scanner.slice_thickness_mm = 8.0;
    spec.grid.size = {192, 192, 13};
    // In the heart frame the slices lie at z = -75, -65, ..., 45 mm.
    spec.grid.mm_from_index = lps_from_heart(spec.anatomy) *
                              centred({1.4, 1.4, 10.0}, spec.grid.size, {14.0, 0.0, -15.0});
  } else {
    std::string known;
    for (const std::string& each : preset_names()) known += (known.empty() ? "" : ", ") + each;
    throw Error(ErrorCode::Usage,
                "there is no phantom preset '" + name + "'; choose one of " + known);
  }
  check_spec(spec);
  return spec;
}

}  // namespace beatlas::phantom
