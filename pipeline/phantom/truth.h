#pragma once
#include <nlohmann/json.hpp>

#include "pipeline/phantom/phantom.h"

namespace beatlas::phantom {

/// What is known about a phantom, as one JSON object that is enough to rebuild it:
/// {"format": "beatlas-phantom-truth", "version": 2, "identity": SHA-256 of the spec,
///  "spec": see spec_to_json, "rr_interval_s", "times_s" [], "volume_loss" [] (s at each time),
///  "volume_loss_definition": text, "ejection_fraction": {"lv_blood", "rv_blood"},
///  "acquisition": see acquisition_json, "structures": [{"name", see part.h, "volume_ml" []}]}.
///  Points are LPS [mm].
[[nodiscard]] nlohmann::json truth_json(const Phantom& phantom);

/// Rebuilds the closed form.
/// @throws Error{InvalidInput} if it is no such object, of a later version, or was changed: the
/// identity must be that of the spec and the volumes those of the phantom.
[[nodiscard]] Phantom phantom_from_truth(const nlohmann::json& truth);

}  // namespace beatlas::phantom
