#pragma once
/// What a user would take instead, measured beside our own in one run: growing of ITK and VTK, mask
/// to distance to surface, dense volumes, NanoVDB grids, Draco phase by phase.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assess/truth_set.h"
#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/field/surface.h"
#include "pipeline/phantom/phantom.h"
#include "runtime/atlas/manifest.h"

namespace beatlas::bench {

using Mask = std::vector<std::uint8_t>;  ///< 1 inside, 0 outside

/// One seed and the window of intensities that grows from it.
struct Growing {
  Index3 seed{0, 0, 0};
  double lower = 0;
  double upper = 0;
};

// ITK. Grids give size and spacing; all happens along their axes.
[[nodiscard]] Mask itk_connected_threshold(const Grid& grid, const std::vector<float>& image,
                                           const Growing& growing);
/// Multiplier 2.5, 4 iterations, initial radius 2; the window is its own.
[[nodiscard]] Mask itk_confidence_connected(const Grid& grid, const std::vector<float>& image,
                                            const Growing& growing);
/// Radius 1.
[[nodiscard]] Mask itk_neighborhood_connected(const Grid& grid, const std::vector<float>& image,
                                              const Growing& growing);
/// Signed distance [mm], negative inside; zero on the centres of the mask's outermost voxels.
[[nodiscard]] std::vector<float> itk_signed_maurer(const Grid& grid, const Mask& mask);
/// Half the difference of the map of the mask and that of what is left: no bias to one side.
[[nodiscard]] std::vector<float> itk_symmetric_maurer(const Grid& grid, const Mask& mask);

// VTK. Surfaces come in the grid's frame [mm].
[[nodiscard]] Mask vtk_threshold_connectivity(const Grid& grid, const std::vector<float>& image,
                                              const Growing& growing);
[[nodiscard]] Mask vtk_connectivity(const Grid& grid, const std::vector<float>& image,
                                    const Growing& growing);
[[nodiscard]] field::TriangleSoup vtk_flying_edges(const Grid& grid,
                                                   const std::vector<float>& level);
[[nodiscard]] field::TriangleSoup vtk_marching_cubes(const Grid& grid,
                                                     const std::vector<float>& level);
/// @param smooth windowed sinc after it, pass band 0.01, 40 iterations
[[nodiscard]] field::TriangleSoup vtk_discrete_surface(const Grid& grid, const Mask& mask,
                                                       bool smooth);

/// What all tables start from.
struct Setting {
  phantom::Phantom phantom;
  Exam exam;
  LabelCycle truth_labels;
  Segmentation found;
  Affine workspace_from_lps = Affine::Identity();
  ShapeCycle shape;        ///< heart, as segmented
  FieldCycle field;        ///< of that shape
  FieldCycle exact_field;  ///< of the closed form's shape: errors of representation alone
  assess::TruthSet truth;
  int repeats = 5;
  std::filesystem::path work;  ///< an empty folder for files

  [[nodiscard]] int phases() const { return exam.stack.phase_count(); }
  [[nodiscard]] double rr_interval_s() const { return exam.stack.rr_interval_s; }
};

struct Column {
  std::string key;  ///< in JSON; ends with the unit
  std::string heading;
  int decimals = 2;
  bool as_ratio = true;  ///< also shown as a multiple of ours
};

struct Row {
  std::string name;
  std::vector<std::optional<double>> figures;  ///< [column]
};

/// The first row is ours.
struct Table {
  std::string key;
  std::string title;
  std::string note;
  std::vector<Column> columns;
  std::vector<Row> rows;
};

[[nodiscard]] Table segmentation_table(const Setting& setting);
[[nodiscard]] Table surface_table(const Setting& setting);
[[nodiscard]] Table field_table(const Setting& setting);
[[nodiscard]] Table storage_table(const Setting& setting);
[[nodiscard]] Table mesh_table(const Setting& setting);

/// Medians of the figures that candidates return, called in turn (A B C A B C ...) so that a busy
/// moment of the machine falls on all of them; one turn before the others is not counted.
/// @return [candidate][figure]
[[nodiscard]] std::vector<std::vector<double>> interleaved(
    int repeats, const std::vector<std::function<std::vector<double>()>>& candidates);

/// Wall clock of a call [ms].
[[nodiscard]] double clocked_ms(const std::function<void()>& work);

struct DistanceErrors {
  double mean_mm = 0;  ///< of |distance|
  double p95_mm = 0;
  double bias_mm = 0;  ///< mean, + outside
};
[[nodiscard]] DistanceErrors summed_errors(std::vector<double> errors);

/// Signed distances [mm] of some of the points, evenly taken, to the closed form's heart in a
/// phase; those whose nearest point lies within 2 mm of a crease are left out.
[[nodiscard]] std::vector<double> distances_to_truth(const Setting& setting, int phase,
                                                     const std::vector<Vec3>& points_lps);

[[nodiscard]] atlas::Manifest manifest_of(const Setting& setting, const std::string& scene);
[[nodiscard]] Mask mask_of(const LabelCycle& labels, int phase, Structure structure);

}  // namespace beatlas::bench
