#pragma once
/// What a network sees of an exam: see the room's README.

#include <optional>
#include <span>
#include <vector>

#include "pipeline/core/exam.h"
#include "pipeline/core/stage_context.h"
#include "pipeline/prior/model.h"

namespace beatlas::prior {

/// Square pixels of `pixel_mm` in the slices of `stack`, about the same middle: as many as fit in
/// best, without the 4 mm along its edges if that saves a `multiple` of mostly nothing.
[[nodiscard]] Grid network_grid(const Grid& stack, double pixel_mm, int multiple);

/// Brightness of a slice in all phases, alike for any scanner.
struct Brightness {
  float low = 0;   ///< percentile 1
  float high = 0;  ///< percentile 99.5; as low where the slice is of one value
  /// @param tone exponent @return 0..1.2^tone
  [[nodiscard]] float of(float value, float tone = kUsualTone) const;
};
/// Percentiles between two values are linear between them. Values that are no numbers count as 0.
[[nodiscard]] Brightness brightness_of(const ImageCycle<float>& images, int slice);

/// One axis of a resampling: pixel o of the result is the sum of weights[o][n] times source pixel
/// first[o] + n; pixels beyond the source are those of its edge.
struct AxisWeights {
  std::vector<int> first;
  std::vector<std::vector<float>> weights;
};
/// @param factor pixel of the result over pixel of the source; both have the same middle
[[nodiscard]] AxisWeights axis_weights(int source, int result, double factor);
/// An image of `width` x `height`, rows first, then columns.
[[nodiscard]] std::vector<float> resampled(std::span<const float> image, int width, int height,
                                           const AxisWeights& along, const AxisWeights& across);

/// The slice below (step -1) or above (step +1) that the network is shown; none: not known.
[[nodiscard]] std::optional<int> neighbour_of(int slice, int step, int slices, double spacing_mm,
                                              double neighbour_mm);

/// All slices of all phases as the network sees them, without neighbours.
struct SeenSlices {
  Grid grid;  ///< see network_grid
  /// [slice][phase], [slice], [slice]: images of grid.slice_count() pixels
  std::vector<std::vector<std::vector<float>>> frames;
  std::vector<std::vector<float>> means;
  std::vector<std::vector<float>> deviations;
};
[[nodiscard]] SeenSlices see(const Cine& stack, const ModelCard& card, const StageContext& context,
                             float tone = kUsualTone);

/// Pixels and slices of the network's grid.
struct Window {
  Index3 first{0, 0, 0};
  Index3 size{0, 0, 0};
};

/// The network's input of one slice and phase: [channel][row][column] of a width and height that
/// are the window's, filled up to the model's multiple.
struct PaddedSize {
  int width = 0;
  int height = 0;
};
[[nodiscard]] PaddedSize padded_size(const Window& window, int multiple);
void fill_input(const SeenSlices& seen, const ModelCard& card, int slice, int phase,
                const Window& window, std::vector<float>& input);

}  // namespace beatlas::prior
