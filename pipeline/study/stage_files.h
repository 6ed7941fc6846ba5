#pragma once
/// Each stage's values as files of a study, and back. The writers return the files they wrote,
/// relative to the study's folder, for Study::commit. The readers give exactly what was written.
/// Writers throw Error{Machine}, readers Error{InvalidInput} naming the file.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/shapes.h"
#include "pipeline/core/surface_map.h"

namespace beatlas::study {

using FileList = std::vector<std::string>;

/// exam/: the stack and each view as 4-D NIfTI; times, exact grids and decisions as JSON.
FileList write_exam(const std::filesystem::path& study, const Exam& exam);
[[nodiscard]] Exam read_exam(const std::filesystem::path& study);
/// Grid and number of phases of the stack, without its voxels.
struct StackLattice {
  Grid grid;
  int phases = 0;
};
[[nodiscard]] StackLattice read_stack_lattice(const std::filesystem::path& study);

/// segment/: labels on the source's grid; coverage of each structure on its part of it and, beside
/// it, how well its boundary is known; the LV's long axis (schemas/long_axis.schema.json).
/// @param as_acquired the labels where the slices lay before import moved them, for
/// labels_source.nii.gz; none where no slice was moved, and then there is no such file
FileList write_segmentation(const std::filesystem::path& study, const Segmentation& segmentation,
                            double frame_interval_s,
                            const std::optional<LabelCycle>& as_acquired = {});

/// A segmentation as it was made, and its labels as they are now: those may have been painted over.
/// Without its uncertainty, which no stage reads.
struct StoredSegmentation {
  Segmentation made;  ///< its labels are all background if labels_as_made.nii.gz is gone
  LabelCycle labels;
};
[[nodiscard]] StoredSegmentation read_segmentation(const std::filesystem::path& study);
/// Of the boundaries as they were made. Empty for a structure that has none.
[[nodiscard]] BoundaryUncertainty read_uncertainty(const std::filesystem::path& study);
/// As it was made, or changed by hand; none if the study holds none.
[[nodiscard]] std::optional<LongAxis> read_long_axis(const std::filesystem::path& study);

/// What the stage `register` gives.
struct Registration {
  Affine workspace_from_lps = Affine::Identity();
  std::vector<ShapeCycle> shapes;
};

/// register/: the shapes and, for the eye, cine and labels on the workspace's 256 x 256 x 64 grid.
/// All NIfTI files carry their place in the patient, so that they overlay the source in a viewer.
/// @param cine, labels grid frame: workspace
FileList write_registration(const std::filesystem::path& study, const Affine& workspace_from_lps,
                            const std::vector<ShapeCycle>& shapes, const ImageCycle<float>& cine,
                            const LabelCycle& labels, double frame_interval_s);
[[nodiscard]] Registration read_registration(const std::filesystem::path& study);
/// Only the map, without the shapes.
[[nodiscard]] Affine read_workspace_from_lps(const std::filesystem::path& study);

/// field/: one .vdb a structure.
FileList write_fields(const std::filesystem::path& study, const std::vector<FieldCycle>& fields);
[[nodiscard]] std::vector<FieldCycle> read_fields(const std::filesystem::path& study);

/// mesh/: one binary .ply a structure and phase, workspace [mm], one connectivity.
FileList write_surfaces(const std::filesystem::path& study,
                        const std::vector<SurfaceCycle>& surfaces);
/// mesh/map_<structure>.csv: a line a vertex of the .ply, its place on the LV's wall and the wall's
/// thickness in every phase.
FileList write_surface_maps(const std::filesystem::path& study,
                            const std::vector<SurfaceMap>& maps);
/// Those that are there, of these surfaces; as made, or changed by hand: a segment that was
/// painted over counts. @throws Error{InvalidInput} naming file and line of what is no map of them
[[nodiscard]] std::vector<SurfaceMap> read_surface_maps(const std::filesystem::path& study,
                                                        const std::vector<SurfaceCycle>& surfaces);
[[nodiscard]] std::vector<SurfaceCycle> read_surfaces(const std::filesystem::path& study);

}  // namespace beatlas::study
