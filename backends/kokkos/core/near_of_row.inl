// Which points of a row's runs of cells are near (core/neighbor_search.cpp), for one instruction set; in float. The
// portable code is append_near.

#if DRENCH_ISA_BITS > 128 && !defined(DRENCH_DOUBLE)

/// Writes the items that are nearer than √h2 (m²) to (x, y, z), in their order, and returns how many there are. What
/// does not fit into `room` is counted only; `out` has room for 16 more.
inline Index near_of_row(const RowRuns& row, Index* out, Index room) {
  Index n = 0;
#if DRENCH_ISA_BITS == 512
  const __m512 x = _mm512_set1_ps(row.at.x), y = _mm512_set1_ps(row.at.y), z = _mm512_set1_ps(row.at.z),
               h2 = _mm512_set1_ps(row.h2);
  const __m512i self = _mm512_set1_epi32(row.self);
  for (int k = 0; k < row.runs; ++k)
    for (Index e = row.first[k]; e < row.last[k]; e += 16) {
      const __m512 rx = _mm512_sub_ps(x, _mm512_loadu_ps(row.x + e)), ry = _mm512_sub_ps(y, _mm512_loadu_ps(row.y + e)),
                   rz = _mm512_sub_ps(z, _mm512_loadu_ps(row.z + e));
      const __m512 square =
          _mm512_add_ps(_mm512_add_ps(_mm512_mul_ps(rx, rx), _mm512_mul_ps(ry, ry)), _mm512_mul_ps(rz, rz));
      const Index left = row.last[k] - e;
      const __mmask16 there = left < 16 ? static_cast<__mmask16>((1u << left) - 1) : static_cast<__mmask16>(0xffff);
      const __m512i item = _mm512_maskz_loadu_epi32(there, row.item + e);
      const __mmask16 near =
          _mm512_mask_cmp_ps_mask(there, square, h2, _CMP_LT_OQ) & _mm512_cmpneq_epi32_mask(item, self);
      if (n <= room) _mm512_storeu_si512(out + n, _mm512_maskz_compress_epi32(near, item));
      n += __builtin_popcount(near);
    }
#else
  const __m256 x = _mm256_set1_ps(row.at.x), y = _mm256_set1_ps(row.at.y), z = _mm256_set1_ps(row.at.z),
               h2 = _mm256_set1_ps(row.h2);
  const __m256i self = _mm256_set1_epi32(row.self);
  for (int k = 0; k < row.runs; ++k)
    for (Index e = row.first[k]; e < row.last[k]; e += 8) {
      const __m256 rx = _mm256_sub_ps(x, _mm256_loadu_ps(row.x + e)), ry = _mm256_sub_ps(y, _mm256_loadu_ps(row.y + e)),
                   rz = _mm256_sub_ps(z, _mm256_loadu_ps(row.z + e));
      const __m256 square =
          _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(rx, rx), _mm256_mul_ps(ry, ry)), _mm256_mul_ps(rz, rz));
      const Index left = row.last[k] - e;
      const unsigned there = left < 8 ? (1u << left) - 1 : 0xffu;
      const __m256i item = _mm256_maskload_epi32(
          row.item + e, _mm256_cmpgt_epi32(_mm256_set1_epi32(left), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)));
      const unsigned own =
          static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(item, self))));
      const unsigned near =
          static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(square, h2, _CMP_LT_OQ))) & there & ~own;
      if (n <= room)
        _mm256_storeu_si256(
            reinterpret_cast<__m256i*>(out + n),
            _mm256_permutevar8x32_epi32(
                item, _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(packed_lanes[near])))));
      n += __builtin_popcount(near);
    }
#endif
  return n;
}

#endif
