#pragma once
/// One phase of a study for editors that show 3-D images, such as 3D Slicer.

#include <filesystem>

namespace beatlas::cli {

/// Writes image_NN.nii.gz; labels_NN.nii.gz as they are now, painted or not, once the study is
/// segmented; and, if it has seeds, seeds_NN.mrk.json with those of that phase or of every phase.
/// What comes back is given by --labels with --labels-phases, and by --seeds.
/// @throws Error{InvalidInput} if the study has no such phase, or labels that are of the images as
/// they were imported before
void export_for_editor(const std::filesystem::path& study, int phase,
                       const std::filesystem::path& folder);

}  // namespace beatlas::cli
