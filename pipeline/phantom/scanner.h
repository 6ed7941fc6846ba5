#pragma once
/// What the scanner does to the phantom. Every degradation is off by default and has a switch of
/// its own; what is drawn at random follows from its seed and the slice, phase or voxel alone, so
/// that no switch changes what another one draws. Section 6 of the reference numbers.

#include <limits>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace beatlas::phantom {

/// How a voxel averages the signals in its box.
enum class PartialVolume {
  Exact,         ///< by the share of the box in each body (see cover.h)
  Supersampled,  ///< by 4 x 4 x 4 points of the box
  None,          ///< by its centre
};

struct ScannerSpec {
  std::string signals = "B";  ///< of the tissues, see signals.h

  // A voxel.
  double slice_thickness_mm = 0;  ///< what a slice averages over, 0..50; 0 = the slice spacing
  PartialVolume partial_volume = PartialVolume::Exact;
  double in_plane_sigma_mm = 0;  ///< Gaussian blur within the slice, 0..5
  double slice_sigma_mm = 0;     ///< Gaussian tails of the slice's box, 0..10

  // Noise and the coil.
  /// Signal of blood over the standard deviation of each channel's noise, >= 1; infinite = no
  /// noise.
  double snr_blood = std::numeric_limits<double>::infinity();
  int noise_seed = 1;
  double bias_share = 0;  ///< of the coil's sensitivity, 0..0.9; see coil_bias.h
  int bias_seed = 1;

  // Time.
  double gating_window_s = 0;  ///< each frame shows the mean over this long, 0..0.5
  int gating_subphases = 5;    ///< moments in that window, 1..25
  double jitter_sigma_s = 0;   ///< of the trigger, drawn for each slice and frame, 0..0.1
  int mistriggered_slices =
      0;  ///< so many slices, drawn among all, show the heart `mistrigger_s` late
  double mistrigger_s = 0.020;  ///< -0.2..0.2
  int trigger_seed = 1;

  // Place.
  double shift_sigma_mm = 0;  ///< of a slice's breath-hold, along i and along j, 0..20
  double shift_limit_mm = 5;  ///< the longest shift, 0..50
  int shift_seed = 1;

  // Flow and what lies outside.
  double flow_void_share = 0;        ///< of blood's signal lost in the jet at peak ejection, 0..1
  bool arms = false;                 ///< arms beside the chest, folded over along `phase_encoding`
  std::string phase_encoding = "i";  ///< "i" or "j": the axis along which the image repeats
};

/// A number of the scanner's, with its name in JSON and its range.
template <class T>
struct ScannerNumber {
  const char* key;
  T ScannerSpec::*member;
  T low;
  T high;
};
/// All of them but snr_blood.
[[nodiscard]] std::span<const ScannerNumber<double>> scanner_numbers();
[[nodiscard]] std::span<const ScannerNumber<int>> scanner_whole_numbers();

/// @param slices of the imaging grid
/// @throws Error{InvalidInput} naming "/scanner/KEY" and its range.
void check_scanner(const ScannerSpec& scanner, int slices);

[[nodiscard]] nlohmann::json scanner_to_json(const ScannerSpec& scanner);
/// Strict; absent keys keep their default. @throws Error{InvalidInput} with the JSON path.
[[nodiscard]] ScannerSpec scanner_from_json(const nlohmann::json& json, const std::string& path);

/// "exact", "supersampled", "none".
[[nodiscard]] std::vector<std::string> partial_volume_names();
/// @throws Error{InvalidInput} naming them.
[[nodiscard]] PartialVolume partial_volume_from_name(const std::string& name);

}  // namespace beatlas::phantom
