#pragma once
/// The bytes of fields/<structure>.field.zst, version 1. One zstd frame that holds, little-endian:
///
///   offset  type      what
///        0  char[8]   kFieldMagic
///        8  u32       kFieldVersion
///       12  u32       phases
///       16  u32[3]    block_count
///       28  u32       leaf count L
///       32  u64       active samples A of all leaves
///       40  f64[3]    origin_mm
///       64  f64[4]    voxel_mm, step_mm, inner_mm, outer_mm
///       96  u8[B]     state of each block (B: product of block_count): 0 outside, 1 inside, 2
///       leaf;
///                     the n-th leaf block is leaf n
///           L x { u64[8] active, u64[8] inside }
///           u8[N]     low bytes of the residuals, N = phases * A
///           u8[N]     high bytes
///
/// Residuals run over phases, then leaves, then active samples. With d[p] the difference of phase p
/// from phase p - 1 (phase 0: the coefficient itself), a residual is d less its prediction from the
/// seven neighbours towards the leaf's origin (the Lorenzo predictor: exact on a field that is a
/// sum of functions of two coordinates), mod 2^16 and zigzag-coded, so that a smooth field leaves
/// small numbers. A neighbour that is inactive counts with its constant in phase 0 and with 0 after
/// it; one outside the leaf counts 0.

#include "runtime/atlas/bytes.h"
#include "runtime/atlas/payloads.h"

namespace beatlas::atlas {

inline constexpr std::string_view kFieldMagic{"BEATFLD\0", 8};
inline constexpr std::uint32_t kFieldVersion = 1;

/// @throws Error{InvalidInput} if the payload breaks what payloads.h says of its layout, or a
/// number is not finite or out of range: voxel_mm 0.01..100, step_mm 1e-6..10, inner_mm and
/// outer_mm (0, 1000], |origin_mm| <= 1e5, block_count 1..4096, phases 1..kMaxPhases.
void check_field(const FieldPayload& field);

/// Bytes of the whole entry -> payload. Nothing is allocated before its size is known to be
/// plausible (see zstd_frame.h), and the counts of the header must account for every byte.
/// @throws Error{InvalidInput}
[[nodiscard]] FieldPayload decode_field(ByteView entry, Structure structure);

/// One leaf's share of the residual code, for the decoder here and the encoder of `pack`.
class LeafPredictor {
 public:
  /// @param field only voxel-independent members are used: step_mm, inner_mm, outer_mm
  LeafPredictor(const FieldPayload& field, const FieldPayload::Leaf& leaf);

  /// Ranks 0..511 of the active samples, in the order of their coefficients.
  [[nodiscard]] const std::vector<std::uint16_t>& active() const noexcept { return active_; }

  /// Starts a phase: forgets the differences of the one before.
  void start_phase(bool first);
  /// Prediction of the difference at `rank` from those that were set since start_phase.
  [[nodiscard]] std::uint16_t predict(std::uint16_t rank) const noexcept;
  void set(std::uint16_t rank, std::uint16_t difference) noexcept;

 private:
  static constexpr int kEdge = FieldPayload::kBlockEdge + 1;  ///< a border of zeros in front
  [[nodiscard]] static constexpr int padded(int rank) noexcept {
    return (rank % 8 + 1) + kEdge * ((rank / 8 % 8 + 1) + kEdge * (rank / 64 + 1));
  }

  std::vector<std::uint16_t> active_;
  std::array<std::uint16_t, FieldPayload::kBlockSamples> constant_{};  ///< of inactive samples
  std::array<std::uint16_t, kEdge * kEdge * kEdge> difference_{};
};

}  // namespace beatlas::atlas
