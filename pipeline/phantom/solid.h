#pragma once
/// Exact signed distance to solids built from ellipsoids, cylinders along z and horizontal planes
/// by union, intersection and difference. Frame: the heart's own (see spec.h); [mm].
///
/// The nearest point of a solid's boundary is a local minimum of the distance on one of its faces,
/// on one of its creases (where two faces meet) or at one of its corners. All of these are
/// enumerated, and only those that lie on the solid's boundary are compared: the nearest point of a
/// face that another body cuts off does not count.

#include <memory>
#include <variant>
#include <vector>

#include "pipeline/phantom/quadric.h"

namespace beatlas::phantom {

/// The half space z < z_mm.
struct Below {
  double z_mm = 0;
};
using Primitive = std::variant<Ellipsoid, Below>;

/// Inside or outside of primitive `index`.
struct Literal {
  int index = 0;
  bool inside = true;
};
/// The intersection of its literals.
using Cell = std::vector<Literal>;

/// A closed space curve as points at most `step_mm` apart.
struct Curve {
  std::vector<Vec3> points;
  double step_mm = 0;
};

/// The curves in which two ellipsoids meet, followed with Newton's method from where sections of
/// the smaller one cross the other. A loop smaller than 1/24 of what their boxes share may be
/// missed. No curve if they do not meet, or only touch; none for two cylinders, which meet in
/// lines.
[[nodiscard]] std::vector<Curve> intersection_curves(const Ellipsoid& a, const Ellipsoid& b,
                                                     double step_mm);

/// The nearest point of a solid's boundary.
struct Nearest {
  Vec3 point = Vec3::Zero();
  double distance_mm = 0;  ///< negative inside the solid; infinite if the solid has no surface
  /// Outward unit normal of the surface there; where faces meet, of one of them.
  Vec3 outward = Vec3::UnitZ();
  /// The primitives that make the point: one on a face, two on a crease, three at a corner, else
  /// -1.
  std::array<int, 3> faces{-1, -1, -1};
};

/// A union of cells of primitives that the solid owns. Immutable, thread-safe.
class Solid {
 public:
  /// @param curve_step_mm spacing of the points that creases between ellipsoids are started from;
  /// they are refined to rounding, so it is speed and not accuracy.
  Solid(std::vector<Primitive> primitives, std::vector<Cell> cells, double curve_step_mm = 0.5);

  [[nodiscard]] bool empty() const { return cells_.empty(); }

  [[nodiscard]] bool contains(const Vec3& x) const;
  /// Error below 1e-7 mm.
  [[nodiscard]] Nearest nearest(const Vec3& x) const;
  [[nodiscard]] double distance_mm(const Vec3& x) const { return nearest(x).distance_mm; }

  /// How fast the boundary moves along `outward` at the nearest point of a query, if every
  /// primitive changes at the rate given: minus the rate of the distance there. A crease and a
  /// corner move as the faces that meet in them make them.
  /// @param rates one a primitive: an Ellipsoid holds the rates of centre and semi-axes (that of an
  /// infinite one is ignored), a Below that of its height; [mm] a unit of the clock
  [[nodiscard]] double outward_speed(const Nearest& nearest,
                                     const std::vector<Primitive>& rates) const;

  /// To 1e-4 ml: the area of each section in closed form (arcs of ellipses, Green's theorem),
  /// integrated along z. @pre bounded along z
  [[nodiscard]] double volume_ml() const;

  /// Distance from x to the nearest crease of the boundary, too large by less than
  /// curve_step_mm^2 / (8 times itself) and by half of `curve_step_mm` on the crease; infinite if
  /// the solid has none.
  [[nodiscard]] double crease_distance_mm(const Vec3& x) const;

  /// Points spread over the boundary about `spacing_mm` apart; they stop half a spacing short of
  /// creases at most. Deterministic.
  [[nodiscard]] std::vector<Vec3> sample(double spacing_mm) const;

  /// Whether x, known to lie on a primitive, is on the boundary of the solid to within 1e-7 mm.
  [[nodiscard]] bool on_boundary(const Vec3& x) const;

  [[nodiscard]] const std::vector<Primitive>& primitives() const { return primitives_; }

 private:
  struct FlatCrease {
    int plane = 0;
    int ellipsoid = 0;
    Ellipse ellipse;
  };
  /// Balls around runs of neighbouring points, to leave far ones out.
  struct Balls {
    std::vector<Vec3> centres;
    std::vector<double> radii;
    Balls() = default;
    Balls(const std::vector<Vec3>& points, double margin_mm);
  };
  struct Corner {
    Vec3 point = Vec3::Zero();
    std::array<int, 3> faces{};
  };
  struct CurvedCrease {
    int first = 0;
    int second = 0;
    Curve curve;
    Balls balls;
  };

  [[nodiscard]] double value_mm(int primitive, const Vec3& x) const;
  [[nodiscard]] Vec3 outward_normal(int primitive, const Vec3& x) const;
  void find_creases(double step_mm);
  /// Of primitives i and j; that of two ellipsoids where i < j, and of a plane and an ellipsoid
  /// where i is the plane.
  void find_creases_between(int i, int j, double step_mm);
  /// Corners that a crease runs into, and points of it that lie on the boundary.
  void look_along(const FlatCrease& crease, double step_mm);
  void look_along(CurvedCrease& crease);
  void find_corners(const CurvedCrease& crease, const Ellipsoid& third, int index);
  [[nodiscard]] double section_mm2(double z_mm) const;
  /// What is nearest to a query so far.
  struct Search;
  void search_faces(Search& search) const;
  void search_creases(Search& search) const;
  void nearest_on_curve(const CurvedCrease& crease, const Vec3& x, double& best, Vec3& point) const;

  std::vector<Primitive> primitives_;
  std::vector<Cell> cells_;
  std::vector<FlatCrease> flat_creases_;
  std::vector<CurvedCrease> curved_creases_;
  std::vector<Corner> corners_;
  std::vector<Vec3> crease_points_;  // valid points of all creases, curve_step_mm apart
  Balls crease_balls_;
};

}  // namespace beatlas::phantom
