#pragma once
/// Ventricle or atrium? In stacks of thick slices the valve planes pass between slices, and blood
/// is blood on both sides.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/segment/chambers.h"

namespace beatlas::segment {

/// Length of the LV, apex to base plane, for which a tricuspid excursion is given (the phantom's).
inline constexpr double kLvLengthMm = 98;

/// Slice indices [phase] in which a technician drew a ventricle; -1 where none; empty: nowhere.
struct DrawnReach {
  std::vector<int> lv_base;  ///< most basal one of the LV, blood or muscle
  std::vector<int> lv_apex;  ///< most apical one of LV blood
  std::vector<int> rv_base;  ///< most basal one of RV blood
};

/// Slice index, fractional, of each ventricle's base plane in every phase; none where slices are
/// thin or nothing shows it.
struct VentricleEnds {
  std::optional<std::vector<double>> lv;
  std::optional<std::vector<double>> rv;
  std::optional<std::vector<double>> lv_apex;  ///< of the cavity's apical end, from views
  bool from_views = false;                     ///< the LV's, see long_axis_views.h
  std::string trouble;                         ///< with the views, a sentence; or empty
  DrawnReach drawn;                            ///< no ventricle ends before it
};

/// From long-axis views where they tell the LV's, otherwise where slices turn into the atrium's
/// (base_plane.h). The RV's, where no slice tells: beside the LV's of the views at end-diastole,
/// and from there it descends by the tricuspid excursion, scaled to the heart's length.
[[nodiscard]] VentricleEnds find_ventricle_ends(const ImageCycle<float>& images,
                                                const std::vector<Cine>& views,
                                                const ImageCycle<std::uint8_t>& labels,
                                                const Chambers& chambers,
                                                double tricuspid_excursion_mm);

/// Beyond the LV's base plane the heart is atria and great vessels: their walls are added to what
/// is bright there. Nothing without that plane.
void wall_atria(const ImageCycle<float>& images, const Chambers& chambers,
                const VentricleEnds& ends, ImageCycle<std::uint8_t>& labels);

/// Every structure ends flat on the base's side, not roundly as at the apex: a ventricle at its
/// base plane, if that was found, and what lies beyond becomes rest of heart. Otherwise half a gap
/// beyond its most basal slice (the fair guess). Then, if beating pools lie beyond the LV's most
/// basal slice (atria), every heart voxel there becomes rest of heart, and the RV, which has no
/// ring of muscle that would show where it ends, is cut by a plane half a gap beyond its most basal
/// slice at end-diastole that descends with the LV's volume loss by
/// the tricuspid excursion, scaled to the heart's length; RV voxels of slices that it has passed
/// become rest of heart (right atrium). Does nothing where slices are thin: then the image shows
/// where the ventricles end.
/// @return the cuts, slice indices in the labels' grid
[[nodiscard]] std::map<Structure, BaseCut> part_ventricles_from_atria(
    ImageCycle<std::uint8_t>& labels, const Chambers& chambers, const VentricleEnds& ends,
    double tricuspid_excursion_mm);

/// Where structures end flat on the base's side, half a gap beyond their most basal slices.
/// @param base_step +1 if the base lies towards larger k, -1 if smaller
[[nodiscard]] std::map<Structure, BaseCut> flat_base_cuts(const ImageCycle<std::uint8_t>& labels,
                                                          int base_step);

/// A plane that cuts off slice `drawn_k` (-1: none) lies half a gap beyond it instead.
/// @param step +1 if what is cut off lies towards larger k
[[nodiscard]] double reaching(double plane_k, int drawn_k, int step);

/// Most basal slice with the structure in a phase; -1 if it has none.
[[nodiscard]] int most_basal(const ImageCycle<std::uint8_t>& labels, std::size_t phase,
                             Structure structure, int base_step);

}  // namespace beatlas::segment
