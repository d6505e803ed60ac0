// GLSL that moves a canonical Gaussian from its rest position by its motion nodes: the blend of
// their poses by its weights. Source: docs/reference/tessera4d.md, section 1.

/**
 * `bindings`: two texels a Gaussian, the heaviest node first; `poses`: two texels a node. A Gaussian
 * without nodes stays as it is. Quaternions are x, y, z, w.
 */
export const CARRY_GLSL = `
vec3 t4Turn(vec4 q, vec3 v) {
  return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v);
}

vec4 t4Product(vec4 a, vec4 b) {
  return vec4(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

void t4Carry(usampler2DArray bindings, usampler2DArray poses, int index, inout vec3 mean,
             inout vec4 rotation) {
  uvec4 words[2] = uvec4[2](texelFetch(bindings, splatTexCoord(2 * index), 0),
                            texelFetch(bindings, splatTexCoord(2 * index + 1), 0));
  vec3 carried = vec3(0.0);
  vec4 heaviest = vec4(0.0), turn = vec4(0.0);
  for (int k = 0; k < 8; ++k) {
    uint word = words[k >> 2][k & 3];
    float weight = float(word >> 10) / 4194303.0;
    if (weight == 0.0) break;
    int texel = 2 * int(word & 1023u);
    vec4 q = uintBitsToFloat(texelFetch(poses, splatTexCoord(texel), 0));
    vec3 offset = uintBitsToFloat(texelFetch(poses, splatTexCoord(texel + 1), 0)).xyz;
    if (k == 0) heaviest = q;
    carried += weight * (t4Turn(q, mean) + offset);
    turn += (dot(q, heaviest) < 0.0 ? -weight : weight) * q;
  }
  if (words[0].x >> 10 == 0u) return;
  mean = carried;
  rotation = normalize(t4Product(turn, rotation));
}
`;
