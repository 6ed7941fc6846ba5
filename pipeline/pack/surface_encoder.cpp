#include <algorithm>
#include <cmath>

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/compression/entropy/symbol_encoding.h>
#include <draco/mesh/mesh.h>

#include "pipeline/pack/pack.h"
#include "pipeline/pack/payload_encoders.h"
#include "runtime/atlas/surface_classes.h"
#include "runtime/atlas/surface_order.h"
#include "runtime/atlas/surface_payload.h"
#include "runtime/base/cycle_modes.h"
#include "runtime/base/error.h"

namespace beatlas::pack {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

constexpr const char* kChanged = "is changed by Draco; check that it is a closed manifold";
constexpr int kMostDracoBits = 30;

[[noreturn]] void refuse(const atlas::SurfacePayload& surface, const std::string& why) {
  throw_invalid("the surface of " + std::string(structure_name(surface.structure)) + " " + why);
}

/// Each triangle turned so that its smallest vertex is first, in order.
std::vector<Triangle> sorted(std::vector<Triangle> triangles) {
  for (Triangle& triangle : triangles) {
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                triangle.end());
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// @param ids also each vertex's number, as a second attribute
void fill_mesh(const atlas::SurfacePayload& surface, const std::vector<Vec3f>& positions, bool ids,
               draco::Mesh& mesh) {
  const auto count = static_cast<std::uint32_t>(positions.size());
  mesh.set_num_points(count);
  mesh.SetNumFaces(surface.triangles.size());
  for (std::uint32_t f = 0; f < surface.triangles.size(); ++f) {
    const auto& [a, b, c] = surface.triangles[f];
    mesh.SetFace(draco::FaceIndex(f),
                 {draco::PointIndex(a), draco::PointIndex(b), draco::PointIndex(c)});
  }
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false,
                3 * sizeof(float), 0);
  draco::GeometryAttribute id;
  id.Init(draco::GeometryAttribute::GENERIC, nullptr, 1, draco::DT_UINT32, false,
          sizeof(std::uint32_t), 0);
  const int position_at = mesh.AddAttribute(position, true, count);
  const int id_at = ids ? mesh.AddAttribute(id, true, count) : -1;
  for (std::uint32_t v = 0; v < count; ++v) {
    const draco::AttributeValueIndex index(v);
    mesh.attribute(position_at)->SetAttributeValue(index, positions[v].data());
    if (ids) mesh.attribute(id_at)->SetAttributeValue(index, &v);
  }
}

atlas::Bytes encode_base(const atlas::SurfacePayload& surface, const std::vector<Vec3f>& positions,
                         double step_mm, bool ids) {
  Vec3f low = positions.front();
  Vec3f high = positions.front();
  for (const Vec3f& position : positions) {
    low = low.cwiseMin(position);
    high = high.cwiseMax(position);
  }
  const double extent_mm = (high - low).cast<double>().maxCoeff();
  const int bits = draco_bits(extent_mm, step_mm);
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(0, 0);
  encoder.SetAttributeExplicitQuantization(draco::GeometryAttribute::POSITION, bits, 3, low.data(),
                                           static_cast<float>(step_mm * ((1 << bits) - 1)));
  draco::Mesh mesh;
  fill_mesh(surface, positions, ids, mesh);
  draco::EncoderBuffer buffer;
  if (bits > kMostDracoBits || !encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) {
    refuse(surface, "cannot be coded by Draco; check that it is a closed manifold");
  }
  const auto* first = reinterpret_cast<const std::byte*>(buffer.data());
  return {first, first + buffer.size()};
}

std::unique_ptr<draco::Mesh> decoded(const atlas::SurfacePayload& surface,
                                     const atlas::Bytes& drc) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(drc.data()), drc.size());
  auto mesh = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!mesh.ok()) refuse(surface, kChanged);
  return std::move(mesh).value();
}

/// What the reader will see of the mean surface, and who is who in it.
struct Base {
  atlas::Bytes drc;
  atlas::JoinedPoints joined;
  atlas::BaseSurface seen;
  std::vector<std::uint32_t> given;  ///< [stored vertex] its number in the surface that was given
};

/// Draco reorders vertices. With their numbers beside it tells who went where; without them it
/// gives the same triangles in the same order, so that the corners of both stand for the same
/// vertices.
Base pack_base(const atlas::SurfacePayload& surface, const std::vector<Vec3f>& mean,
               double step_mm) {
  Base out;
  out.drc = encode_base(surface, mean, step_mm, false);
  const auto plain = decoded(surface, out.drc);
  const auto numbered = decoded(surface, encode_base(surface, mean, step_mm, true));
  const draco::PointAttribute* id = numbered->GetNamedAttribute(draco::GeometryAttribute::GENERIC);
  if (id == nullptr || plain->num_faces() != surface.triangles.size() ||
      numbered->num_faces() != plain->num_faces()) {
    refuse(surface, kChanged);
  }
  constexpr std::uint32_t kNone = UINT32_MAX;
  std::vector<std::uint32_t> id_of_point(plain->num_points(), kNone);
  for (draco::FaceIndex face(0); face < plain->num_faces(); ++face) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      std::uint32_t number = kNone;
      id->GetValue(id->mapped_index(numbered->face(face)[corner]), &number);
      std::uint32_t& known = id_of_point[plain->face(face)[corner].value()];
      if (number >= mean.size() || (known != kNone && known != number)) refuse(surface, kChanged);
      known = number;
    }
  }
  std::vector<std::uint32_t> first_point(mean.size(), kNone);
  for (std::uint32_t point = 0; point < id_of_point.size(); ++point) {
    const std::uint32_t number = id_of_point[point];
    if (number == kNone) refuse(surface, kChanged);
    if (first_point[number] == kNone) {
      first_point[number] = point;
      out.given.push_back(number);
    } else {
      out.joined.push_back({point, first_point[number]});
    }
  }
  try {
    out.seen =
        atlas::join_points(atlas::decode_base(out.drc, id_of_point.size(),
                                              static_cast<std::uint32_t>(surface.triangles.size())),
                           out.joined);
  } catch (const Error&) {
    refuse(surface, kChanged);
  }
  std::vector<Triangle> named = out.seen.triangles;
  for (Triangle& triangle : named) {
    for (std::uint32_t& corner : triangle) corner = out.given[corner];
  }
  if (out.given.size() != mean.size() || sorted(named) != sorted(surface.triangles)) {
    refuse(surface, kChanged);
  }
  return out;
}

/// Makes the counts of a surface's motion, vertex by vertex in coding order.
class MotionCounter {
 public:
  /// @param step_mm of the counts
  /// @param most_mm how far a stored vertex may be from where it was
  MotionCounter(const atlas::SurfacePayload& surface, const Base& base, double step_mm,
                double most_mm)
      : surface_(surface),
        base_(base),
        step_mm_(step_mm),
        most_mm_(most_mm),
        basis_(static_cast<int>(surface.positions.size())),
        weights_(cycle_modes(static_cast<int>(surface.positions.size()))),
        order_(base.seen.triangles, base.seen.positions),
        terms_(basis_.modes() * base.given.size()),
        counts(3 * basis_.modes() * base.given.size()) {}

  /// False if a vertex cannot be held within the error.
  bool run() {
    return std::all_of(order_.vertices().begin(), order_.vertices().end(),
                       [this](std::uint32_t v) { return add(v); });
  }

  [[nodiscard]] const atlas::SurfaceOrder& order() const { return order_; }

 private:
  bool add(std::uint32_t v) {
    const std::size_t modes = basis_.modes();
    const std::size_t phases = modes + 1;
    const Eigen::Matrix3d frame = order_.frame(v);
    Vec3* own = terms_.data() + modes * v;
    std::fill_n(own, modes, Vec3::Zero());
    const auto known = order_.known(v);
    const std::vector<double> weights = order_.weights(v);
    for (std::size_t n = 0; n < known.size(); ++n) {
      for (std::size_t m = 0; m < modes; ++m) {
        own[m] += weights[n] * terms_[modes * known[n] + m];
      }
    }
    std::vector<Vec3> errors(phases);  // what is still to be added, phase by phase
    const Vec3 mean = base_.seen.positions[v].cast<double>();
    for (std::size_t p = 0; p < phases; ++p) {
      errors[p] = surface_.positions[p][base_.given[v]].cast<double>() - mean;
    }
    std::vector<Vec3> wanted(modes);
    basis_.analyse(errors.data(), wanted.data());
    std::int32_t* to = counts.data() + 3 * modes * v;
    for (std::size_t m = 0; m < modes; ++m) {
      const Vec3 along = frame * (wanted[m] - own[m]) / step_mm_;
      for (int row = 0; row < 3; ++row) {
        const double count = std::round(along[row]);
        if (!(std::abs(count) <= kMostCount)) return false;
        to[3 * m + static_cast<std::size_t>(row)] = static_cast<std::int32_t>(count);
        own[m] += step_mm_ * count * frame.row(row).transpose();
      }
    }
    for (std::size_t p = 0; p < phases; ++p) {
      for (std::size_t m = 0; m < modes; ++m) errors[p] -= weights_[(m + 1) * phases + p] * own[m];
    }
    return hold(frame, errors, own, to);
  }

  /// Rounds counts the other way until no phase is too far off; of 15 phases about a tenth of the
  /// vertices need it, one or two counts each. What is lowered is the excess of the phases that are
  /// too far off or, where no count lowers that, of those that are nearly so.
  bool hold(const Eigen::Matrix3d& frame, std::vector<Vec3>& errors, Vec3* own,
            std::int32_t* to) const {
    constexpr int kMostChanges = 40;
    constexpr double kNearShare = 0.6;
    const double most = most_mm_ * most_mm_;
    bool is_near = false;
    const auto change_now = [&] {
      return best_change(frame, errors, is_near ? kNearShare * most : most);
    };
    for (int n = 0; n < kMostChanges; ++n) {
      if (excess(errors, most) == 0) return true;
      Change found = change_now();
      if (found.by == 0) {
        is_near = !is_near;
        found = change_now();
      }
      if (found.by == 0) return false;
      const Vec3 along = found.by * step_of(frame, found.slot);
      to[found.slot] += found.by;
      own[found.slot / 3] += along;
      const double* weight = weights_.data() + (found.slot / 3 + 1) * errors.size();
      for (std::size_t p = 0; p < errors.size(); ++p) errors[p] -= weight[p] * along;
    }
    return excess(errors, most) == 0;
  }

  struct Change {
    std::size_t slot = 0;
    int by = 0;  ///< 0: none lowers the excess
  };

  static double beyond(const Vec3& error, double most) {
    const double more = std::max(0.0, error.squaredNorm() - most);
    return more * more;
  }
  static double excess(const std::vector<Vec3>& errors, double most) {
    double sum = 0;
    for (const Vec3& error : errors) sum += beyond(error, most);
    return sum;
  }
  [[nodiscard]] Vec3 step_of(const Eigen::Matrix3d& frame, std::size_t slot) const {
    return step_mm_ * frame.row(static_cast<Eigen::Index>(slot % 3)).transpose();
  }

  [[nodiscard]] Change best_change(const Eigen::Matrix3d& frame, const std::vector<Vec3>& errors,
                                   double most) const {
    Change out;
    double best = excess(errors, most);
    for (std::size_t slot = 0; slot < 3 * basis_.modes(); ++slot) {
      const Vec3 along = step_of(frame, slot);
      const double* weight = weights_.data() + (slot / 3 + 1) * errors.size();
      for (const int by : {-1, 1}) {
        double sum = 0;
        for (std::size_t p = 0; p < errors.size() && sum < best; ++p) {
          sum += beyond(errors[p] - by * weight[p] * along, most);
        }
        if (sum < best) {
          best = sum;
          out = {slot, by};
        }
      }
    }
    return out;
  }

  static constexpr double kMostCount = 1 << 24;

  const atlas::SurfacePayload& surface_;
  const Base& base_;
  double step_mm_;
  double most_mm_;
  atlas::MotionBasis basis_;
  std::vector<double> weights_;  ///< [mode][phase]
  atlas::SurfaceOrder order_;
  std::vector<Vec3> terms_;  ///< [vertex][mode - 1], as the reader will have them

 public:
  std::vector<std::int32_t> counts;  ///< [vertex][mode - 1][row]
};

std::vector<std::uint16_t> scales_of(const std::vector<std::int32_t>& counts, std::size_t modes) {
  std::vector<std::uint16_t> out;
  const std::size_t vertices = modes == 0 ? 0 : counts.size() / (3 * modes);
  for (std::size_t mode = 0; mode < modes; ++mode) {
    std::array<double, atlas::kMotionKinds> sums{};
    for (std::size_t v = 0; v < vertices; ++v) {
      for (std::size_t row = 0; row < 3; ++row) {
        sums[atlas::MotionClasses::kind_of(row)] += std::abs(counts[3 * (modes * v + mode) + row]);
      }
    }
    const auto scale = [&](double sum) {
      return static_cast<std::uint16_t>(
          std::clamp(64 * sum / static_cast<double>(vertices), 1.0, 65535.0));
    };
    out.push_back(scale(sums[0]));
    out.push_back(scale(sums[1] / 2));
  }
  return out;
}

atlas::Bytes write_motion(const atlas::SurfacePayload& surface, const Base& base,
                          const MotionCounter& made, double step_mm) {
  const std::size_t modes = surface.positions.size() - 1;
  atlas::ByteWriter writer;
  writer.put_text(atlas::kMotionMagic);
  writer.put(atlas::kMotionVersion);
  writer.put(static_cast<std::uint32_t>(base.given.size()));
  writer.put(static_cast<std::uint32_t>(base.seen.triangles.size()));
  writer.put(static_cast<std::uint32_t>(surface.positions.size()));
  writer.put(static_cast<std::uint32_t>(base.joined.size()));
  writer.put(step_mm);
  writer.put_many(base.joined.data(), base.joined.size());
  const std::vector<std::uint16_t> scales = scales_of(made.counts, modes);
  writer.put_many(scales.data(), scales.size());

  std::array<std::vector<std::uint32_t>, atlas::kMotionClasses> codes;
  atlas::MotionClasses classes(scales, base.given.size());
  for (const std::uint32_t v : made.order().vertices()) {
    classes.begin(v, made.order().known(v));
    for (std::size_t slot = 0; slot < classes.slots(); ++slot) {
      const std::int32_t count = made.counts[classes.slots() * v + slot];
      codes[classes.of(slot)].push_back(static_cast<std::uint32_t>(count) << 1U ^
                                        static_cast<std::uint32_t>(count >> 31));
      classes.add(slot, count);
    }
  }
  for (const auto& code : codes) writer.put(static_cast<std::uint32_t>(code.size()));
  draco::EncoderBuffer buffer;
  draco::Options options;
  for (const auto& code : codes) {
    if (!code.empty() &&
        !draco::EncodeSymbols(code.data(), static_cast<int>(code.size()), 1, &options, &buffer)) {
      refuse(surface, "cannot be coded; check its phases");
    }
  }
  writer.put_many(buffer.data(), buffer.size());
  return writer.take();
}

std::vector<Vec3f> mean_of(const atlas::SurfacePayload& surface) {
  const std::vector<Vec3f>& first = surface.positions.front();
  std::vector<Vec3f> out(first.size());
  for (std::size_t v = 0; v < out.size(); ++v) {
    Vec3 sum = Vec3::Zero();
    for (const auto& phase : surface.positions) sum += phase[v].cast<double>();
    out[v] = (sum / static_cast<double>(surface.positions.size())).cast<float>();
  }
  return out;
}

/// How far rounding to single precision may move a vertex.
double float_error_mm(const atlas::SurfacePayload& surface) {
  float most = 0;
  for (const auto& phase : surface.positions) {
    for (const Vec3f& position : phase) most = std::max(most, position.cwiseAbs().maxCoeff());
  }
  return std::sqrt(3.0) * std::ldexp(static_cast<double>(most), -24);
}

double largest_error_mm(const atlas::SurfacePayload& given, const atlas::SurfacePayload& stored,
                        const std::vector<std::uint32_t>& order) {
  double largest = 0;
  for (std::size_t phase = 0; phase < given.positions.size(); ++phase) {
    for (std::size_t v = 0; v < order.size(); ++v) {
      const Vec3 error = given.positions[phase][order[v]].cast<double>() -
                         stored.positions[phase][v].cast<double>();
      largest = std::max(largest, error.norm());
    }
  }
  return largest;
}

void refuse_far_motion(const atlas::SurfacePayload& surface, double step_mm) {
  for (const auto& phase : surface.positions) {
    for (std::size_t v = 0; v < phase.size(); ++v) {
      if (!((phase[v] - surface.positions[0][v]).cwiseAbs().maxCoeff() <= INT16_MAX * step_mm)) {
        refuse(surface, "moves by more than " +
                            std::to_string(static_cast<int>(INT16_MAX * step_mm)) +
                            " mm; check its phases");
      }
    }
  }
}

}  // namespace

int draco_bits(double extent_mm, double surface_step_mm) {
  int bits = 1;
  while (bits <= kMostDracoBits && surface_step_mm * ((1 << bits) - 1) < extent_mm) ++bits;
  return bits;
}

PackedSurface pack_surface(const atlas::SurfacePayload& surface, double step_mm) {
  if (!(step_mm >= 0.002 && step_mm <= 0.5)) {
    throw Error(ErrorCode::Usage, "surface_step_mm must be from 0.002 to 0.5 mm");
  }
  atlas::check_surface(surface);
  refuse_far_motion(surface, step_mm);
  const std::vector<Vec3f> mean = mean_of(surface);
  const double most_mm = step_mm - float_error_mm(surface) - 1e-6;
  for (double quantum_mm = step_mm; quantum_mm > step_mm / 10; quantum_mm *= 0.85) {
    Base base = pack_base(surface, mean, quantum_mm / 2);
    MotionCounter made(surface, base, quantum_mm, most_mm);
    if (!made.run()) continue;
    PackedSurface packed{std::move(base.drc), write_motion(surface, base, made, quantum_mm),
                         std::move(base.given)};
    const atlas::SurfacePayload stored =
        atlas::decode_surface(packed.drc, packed.motion, surface.structure);
    if (largest_error_mm(surface, stored, packed.given) <= step_mm) return packed;
  }
  refuse(surface, "cannot be stored within its step; check that it lies near the workspace");
}

}  // namespace beatlas::pack
