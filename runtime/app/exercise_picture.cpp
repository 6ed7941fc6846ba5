#include "runtime/app/exercise_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "runtime/palpation/segments.h"
#include "runtime/plot/svg.h"

namespace beatlas::app {
namespace {

using plot::pixels;

constexpr double kSide = 420;

/// What a place of the wall is in the picture; later ones are drawn over earlier ones.
enum class Shade : std::uint8_t { Unreachable, Missed, Palpated, MissedLesion, FoundLesion };
/// Okabe and Ito's vermilion for what was hidden, their blue for what was palpated.
constexpr std::array<std::array<int, 3>, 5> kShades{
    {{225, 225, 225}, {250, 240, 190}, {86, 160, 215}, {243, 180, 140}, {213, 94, 0}}};

std::string colour(Shade shade, double light) {
  std::string out = "rgb(";
  for (const int full : kShades[static_cast<std::size_t>(shade)]) {
    if (out.back() != '(') out += ',';
    out += std::to_string(static_cast<int>(std::lround(light * full)));
  }
  out += ')';
  return out;
}

std::vector<Shade> shades(const ExerciseGround& atlas, const PalpationPicture& picture) {
  const palpation::LvWall& wall = atlas.wall();
  std::vector<Shade> out;
  for (std::uint32_t v = 0; v < wall.vertex_count(); ++v) {
    const bool ill = std::any_of(
        picture.lesions.begin(), picture.lesions.end(), [&](const exercise::Lesion& lesion) {
          return (wall.mm(v) - wall.mm(lesion.vertex)).norm() <= lesion.radius_mm;
        });
    const bool palpated = picture.under_finger_s[v] > 0;
    if (ill) {
      out.push_back(palpated ? Shade::FoundLesion : Shade::MissedLesion);
    } else if (!atlas.ground().touchable[v]) {
      out.push_back(Shade::Unreachable);
    } else {
      out.push_back(palpated ? Shade::Palpated : Shade::Missed);
    }
  }
  return out;
}

/// A white disc with a word, so that it reads on every colour.
std::string label(double x, double y, const std::string& word) {
  return "<circle cx=\"" + pixels(x) + "\" cy=\"" + pixels(y) +
         "\" r=\"9\" fill=\"#fff\" stroke=\"#000\" stroke-width=\"1.5\"/>" +
         plot::text_at(x, y + 4, "middle", word, " font-weight=\"bold\" font-size=\"11\"");
}

template <class Place>
std::string labels(const PalpationPicture& picture, const Place& place) {
  std::string out;
  for (std::size_t n = 0; n < picture.places.size(); ++n) {
    out += place(picture.places[n], std::string(1, static_cast<char>('A' + n)));
  }
  for (std::size_t n = 0; n < picture.marks.size(); ++n) {
    out += place(picture.marks[n].place.vertex, std::to_string(n + 1));
  }
  return out;
}

std::string sector_outline(int segment, double middle, double radius) {
  const palpation::BullsEyeSector sector = palpation::bulls_eye_sector(segment);
  const auto at = [&](double r, double angle) {
    return pixels(middle + radius * r * std::cos(angle)) + " " +
           pixels(middle - radius * r * std::sin(angle));
  };
  if (sector.inner == 0) {
    return "<circle cx=\"" + pixels(middle) + "\" cy=\"" + pixels(middle) + "\" r=\"" +
           pixels(radius * sector.outer) + "\" fill=\"none\" stroke=\"#555\"/>";
  }
  const std::string outer = pixels(radius * sector.outer);
  const std::string inner = pixels(radius * sector.inner);
  return "<path d=\"M" + at(sector.inner, sector.begin_rad) + " L" +
         at(sector.outer, sector.begin_rad) + " A" + outer + " " + outer + " 0 0 0 " +
         at(sector.outer, sector.end_rad) + " L" + at(sector.inner, sector.end_rad) + " A" + inner +
         " " + inner + " 0 0 1 " + at(sector.inner, sector.begin_rad) +
         "\" fill=\"none\" stroke=\"#555\"/>";
}

/// Axes of a picture of the wall: right, up, towards the viewer.
struct View {
  Vec3 right;
  Vec3 up;
  Vec3 towards;
};

/// From both sides of the wall that is touched, 50 degrees off its middle, the base above.
std::array<View, 2> views_of(const ExerciseGround& atlas) {
  const palpation::LvWall& wall = atlas.wall();
  Vec3 base = Vec3::Zero();
  Vec3 apex = Vec3::Zero();
  Vec3 towards = Vec3::Zero();
  double bases = 0;
  double apices = 0;
  for (std::uint32_t v = 0; v < wall.vertex_count(); ++v) {
    const auto s = static_cast<double>(wall.map().long_axis[v]);
    if (s > 0.75) {
      base += wall.mm(v);
      ++bases;
    }
    if (s < 0.25) {
      apex += wall.mm(v);
      ++apices;
    }
    if (atlas.ground().touchable[v]) towards += wall.muscle_share()[v] * wall.outward(v);
  }
  Vec3 up = base / std::max(bases, 1.0) - apex / std::max(apices, 1.0);
  up = up.norm() > 0 ? Vec3(up.normalized()) : Vec3(Vec3::UnitZ());
  towards -= towards.dot(up) * up;
  towards = towards.norm() > 1e-6 ? Vec3(towards.normalized()) : Vec3(up.unitOrthogonal());
  std::array<View, 2> out;
  for (std::size_t n = 0; n < out.size(); ++n) {
    const double turn = (n == 0 ? -1 : 1) * 50 * std::numbers::pi / 180;
    const Vec3 eye = Eigen::AngleAxisd(turn, up) * towards;
    out[n] = {.right = up.cross(eye), .up = up, .towards = eye};
  }
  return out;
}

std::string view_svg(const ExerciseGround& atlas, const PalpationPicture& picture,
                     const std::vector<Shade>& shade, const View& view, double left) {
  const palpation::LvWall& wall = atlas.wall();
  Vec3 low = Vec3::Constant(1e9);
  Vec3 high = Vec3::Constant(-1e9);
  std::vector<Vec3> seen;
  for (std::uint32_t v = 0; v < wall.vertex_count(); ++v) {
    const Vec3 p = wall.mm(v);
    seen.emplace_back(p.dot(view.right), p.dot(view.up), p.dot(view.towards));
    low = low.cwiseMin(seen.back());
    high = high.cwiseMax(seen.back());
  }
  const double scale = 0.9 * kSide / std::max((high - low).head<2>().maxCoeff(), 1.0);
  const Vec3 middle = 0.5 * (low + high);
  const auto x = [&](const Vec3& p) { return left + kSide / 2 + scale * (p.x() - middle.x()); };
  const auto y = [&](const Vec3& p) { return kSide / 2 - scale * (p.y() - middle.y()); };

  struct Face {
    double depth;
    std::string svg;
  };
  std::vector<Face> faces;
  for (const auto& triangle : atlas.endocardium().triangles) {
    const Vec3& a = seen[triangle[0]];
    const Vec3& b = seen[triangle[1]];
    const Vec3& c = seen[triangle[2]];
    const Vec3 normal = (b - a).cross(c - a);
    if (!(normal.z() > 0)) continue;
    const double light = 0.55 + 0.45 * normal.z() / normal.norm();
    const Shade worst = std::max({shade[triangle[0]], shade[triangle[1]], shade[triangle[2]]});
    std::string points;
    for (const Vec3* p : {&a, &b, &c}) points += pixels(x(*p)) + "," + pixels(y(*p)) + " ";
    const std::string fill = colour(worst, light);
    faces.push_back({a.z() + b.z() + c.z(), "<polygon points=\"" + points + "\" fill=\"" + fill +
                                                "\" stroke=\"" + fill + "\"/>\n"});
  }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Face& a, const Face& b) { return a.depth < b.depth; });
  std::string out;
  for (const Face& face : faces) out += face.svg;
  return out + labels(picture, [&](std::uint32_t v, const std::string& word) {
           return wall.outward(v).dot(view.towards) > 0 ? label(x(seen[v]), y(seen[v]), word)
                                                        : std::string();
         });
}

}  // namespace

std::string bulls_eye_svg(const ExerciseGround& atlas, const PalpationPicture& picture) {
  constexpr double kMiddle = kSide / 2;
  constexpr double kRadius = 0.44 * kSide;
  const palpation::LvWall& wall = atlas.wall();
  const std::vector<Shade> shade = shades(atlas, picture);
  const auto place = [&](std::uint32_t v) {
    const auto [x, y] = palpation::bulls_eye_place(static_cast<double>(wall.map().long_axis[v]),
                                                   static_cast<double>(wall.map().angle_rad[v]));
    return std::array{kMiddle + kRadius * x, kMiddle - kRadius * y};
  };
  std::string out = plot::svg_head(kSide, kSide);
  for (int drawn = 0; drawn < static_cast<int>(kShades.size()); ++drawn) {
    for (std::uint32_t v = 0; v < wall.vertex_count(); ++v) {
      if (!(wall.wall_mm()[v] > 0) || static_cast<int>(shade[v]) != drawn) continue;
      const auto [x, y] = place(v);
      out += "<circle cx=\"" + pixels(x) + "\" cy=\"" + pixels(y) + "\" r=\"5\" fill=\"" +
             colour(shade[v], 1) + "\"/>\n";
    }
  }
  for (int segment = 1; segment <= palpation::kSegments; ++segment) {
    out += sector_outline(segment, kMiddle, kRadius) + "\n";
  }
  out +=
      plot::text_at(kMiddle, 14, "middle", "anterior") +
      plot::text_at(kMiddle, kSide - 6, "middle", "inferior") +
      plot::text_at(12, kMiddle, "middle", "septum",
                    " transform=\"rotate(-90 12 " + pixels(kMiddle) + ")\"") +
      plot::text_at(kSide - 8, kMiddle, "middle", "lateral",
                    " transform=\"rotate(90 " + pixels(kSide - 8) + " " + pixels(kMiddle) + ")\"");
  out += labels(picture, [&](std::uint32_t v, const std::string& word) {
    const auto [x, y] = place(v);
    return label(x, y, word);
  });
  return out + "</svg>\n";
}

std::string wall_svg(const ExerciseGround& atlas, const PalpationPicture& picture) {
  const std::vector<Shade> shade = shades(atlas, picture);
  const std::array<View, 2> views = views_of(atlas);
  std::string out = plot::svg_head(2 * kSide, kSide);
  for (std::size_t n = 0; n < views.size(); ++n) {
    out += view_svg(atlas, picture, shade, views[n], kSide * static_cast<double>(n));
  }
  return out + "</svg>\n";
}

std::string colour_key() {
  constexpr std::array<const char*, 5> kMeanings{"no finger gets there", "not palpated", "palpated",
                                                 "hidden, not palpated", "hidden and palpated"};
  std::string out = "<p class=\"key\">";
  for (std::size_t n = 0; n < kMeanings.size(); ++n) {
    out += "<span style=\"background:" + colour(static_cast<Shade>(n), 1) + "\"></span>" +
           kMeanings[n] + " ";
  }
  return out + "</p>\n";
}

}  // namespace beatlas::app
