#include "pipeline/segment/groundwork.h"

#include <algorithm>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/segment/drawn_ends.h"

namespace beatlas::segment {

std::vector<LvPlace> places_beside(const std::vector<int>& found, const Grid& grid,
                                   const std::vector<Seed>& drawn) {
  std::vector<LvPlace> places = lv_places(grid, drawn);
  std::erase_if(places, [&](const LvPlace& place) {
    return std::binary_search(found.begin(), found.end(), place.k);
  });
  return places;
}

bool turned_by(const std::vector<Seed>& drawn, const LvSlices& slices) {
  if (slices.doubted.empty()) return false;
  const std::vector<LvPlace> places = lv_places(slices.grid, drawn);
  return std::any_of(places.begin(), places.end(), [&](const LvPlace& place) {
    return std::binary_search(slices.doubted.begin(), slices.doubted.end(), place.k);
  });
}

namespace {

/// Thick slices only; in thin ones the long axis tells the base.
void turn_if_drawn(const std::vector<Seed>& drawn, LvSlices& slices, Chambers& chambers) {
  if (slices.grid.spacing_mm()[2] < kThickSlicesMm) return;
  slices.doubted = doubted_base(chambers);
  slices.turned = turned_by(drawn, slices);
  if (slices.turned) chambers.base_step = -chambers.base_step;
}

/// @param chambers before adopt_seeds
LvSlices slices_of(const Grid& grid, const Chambers& chambers, const std::vector<Seed>& drawn) {
  LvSlices out{grid, {}, {}, {}, false};
  for (const LvSlice& slice : chambers.lv) out.found.push_back(slice.k);
  out.adopted = places_beside(out.found, grid, drawn);
  return out;
}

/// Seeds found in slices across the LV's long axis, where ventricles look their best, on the grid
/// of the images; `chambers` become those of these slices. Empty if they show no ventricle.
LabelImages upright_seeds(const ImageCycle<float>& images, const std::vector<Seed>& drawn,
                          Chambers& chambers, std::vector<LvSlices>& looked,
                          StageContext& context) {
  const ImageCycle<float> upright = across_axis(images, *chambers.axis);
  const TemporalStats stats = temporal_stats(upright);
  Chambers found = find_chambers(upright, stats, context);
  if (!found.found_lv()) return {};
  found.axis = chambers.axis;
  found.height_mm = found.axis->heights_mm(upright.grid);
  looked.push_back(slices_of(upright.grid, found, drawn));
  adopt_seeds(upright, drawn, found);
  const LabelImages there = automatic_seeds(upright, stats, found);
  chambers = std::move(found);
  chambers.height_mm = chambers.axis->heights_mm(images.grid);

  LabelImages seeds(images.phases.size(), std::vector<std::uint8_t>(images.grid.count()));
  const Affine to_upright =
      upright.grid.mm_from_index.inverse(Eigen::Affine) * images.grid.mm_from_index;
  const Grid& grid = images.grid;
  parallel_for(static_cast<std::size_t>(grid.size[2]), [&](std::size_t slice) {
    const auto k = static_cast<int>(slice);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Vec3 at = to_upright * Vec3(i, j, k);
        const Index3 near{static_cast<int>(std::lround(at[0])),
                          static_cast<int>(std::lround(at[1])),
                          static_cast<int>(std::lround(at[2]))};
        const bool inside = upright.grid.contains(near[0], near[1], near[2]);
        for (std::size_t p = 0; p < seeds.size(); ++p) {
          // What lies farther out than those slices reach is no heart.
          std::uint8_t& seed = seeds[p][grid.offset(i, j, k)];
          seed = kLabelBackground;
          if (inside) seed = there[p][upright.grid.offset(near[0], near[1], near[2])];
        }
      }
    }
  });
  return seeds;
}

}  // namespace

Groundwork lay_groundwork(const ImageCycle<float>& images, const Box& moving, const Box& box,
                          const std::vector<Seed>& drawn, bool parts_atria, int known_step,
                          double tricuspid_excursion_mm, StageContext& context) {
  const TemporalStats stats = temporal_stats(images);
  Groundwork out{moving, box, stats.noise, classify_motion(stats), {}, {}, {}};
  Chambers& chambers = out.chambers;
  chambers = find_chambers(images, stats, context);
  context.check_cancelled();
  out.looked.push_back(slices_of(images.grid, chambers, drawn));
  if (known_step != 0 && chambers.found_lv() && images.grid.spacing_mm()[2] >= kThickSlicesMm) {
    chambers.base_step = known_step;
  }
  adopt_seeds(images, drawn, chambers);
  turn_if_drawn(drawn, out.looked.back(), chambers);
  if (out.looked.back().turned) {
    context.log("seeds of LV blood lie in what was taken for its base: base and apex turned over");
  }
  if (parts_atria) chambers.axis = find_long_axis(images, chambers, tricuspid_excursion_mm);
  if (chambers.axis) chambers.height_mm = chambers.axis->heights_mm(images.grid);
  if (chambers.axis) {
    out.automatic = upright_seeds(images, drawn, chambers, out.looked, context);
  }
  if (out.automatic.empty()) out.automatic = automatic_seeds(images, stats, chambers);
  return out;
}

}  // namespace beatlas::segment
