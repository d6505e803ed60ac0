// A block on the GPU: its textures, and the program that computes Gaussian `index` as a splat at
// its time t (tau of its window where it has one): mean, rotation, opacity, and colour towards the sliced mean. Spark projects and sorts
// splats. Source: docs/reference/tessera4d.md, 1; SH: [3DGS].
import { dyno, SplatGenerator, SplatTransformer } from "@sparkjsdev/spark";
import * as THREE from "three";
import { CARRY_GLSL } from "./carry_shader";
import { writePoses, type MotionNodes } from "./motion_nodes";
import { memoryOf, poseTexels, ROW, type PackedBlock, type Words } from "./packing";

/** A place that all blocks of a scene share. */
export function eyeUniform() {
  return new dyno.DynoVec3({ value: new THREE.Vector3(), key: "eye" });
}

/** What all blocks of one window share: changing a value here changes every later frame. */
export class SliceUniforms {
  /** their time; 1 where the anchor is clamped to the clip; least opacity that is drawn; highest SH degree */
  readonly when = new dyno.DynoVec4({ value: new THREE.Vector4(0, 1, 1 / 255, 3), key: "when" });

  /** factors of all colours */
  readonly light = new dyno.DynoVec3({ value: new THREE.Vector3(1, 1, 1), key: "light" });

  constructor(readonly eye: ReturnType<typeof eyeUniform>) {}
}

const GLSL = `
float t4Halves[24];

void t4Read(usampler2DArray words, int texel, int at) {
  uvec4 w = texelFetch(words, splatTexCoord(texel), 0);
  for (int k = 0; k < 4; ++k) {
    vec2 pair = unpackHalf2x16(w[k]);
    t4Halves[at + 2 * k] = pair.x;
    t4Halves[at + 2 * k + 1] = pair.y;
  }
}

vec3 t4Coefficient(int k) {
  return vec3(t4Halves[3 * k], t4Halves[3 * k + 1], t4Halves[3 * k + 2]);
}

vec4 t4Rotation(uint word) {
  int largest = int(word >> 30);
  uvec3 steps = uvec3(word >> 20, word >> 10, word) & 1023u;
  vec3 rest = (vec3(steps) / 1023.0 - 0.5) * 1.41421356237;
  float whole = sqrt(max(0.0, 1.0 - dot(rest, rest)));
  vec4 wxyz = largest == 0 ? vec4(whole, rest)
    : largest == 1 ? vec4(rest.x, whole, rest.yz)
    : largest == 2 ? vec4(rest.xy, whole, rest.z)
    : vec4(rest, whole);
  return wxyz.yzwx;
}

vec3 t4Degrees12(usampler2DArray low, usampler2DArray mid, int index, int count, vec3 d) {
  t4Read(low, 2 * index, 0);
  t4Read(low, 2 * index + 1, 8);
  vec3 sum = 0.4886025119 *
    (-d.y * t4Coefficient(0) + d.z * t4Coefficient(1) - d.x * t4Coefficient(2));
  if (index >= count) return sum;
  t4Read(mid, index, 16);
  vec3 q = d * d;
  sum += 1.0925484306 * (d.x * d.y * t4Coefficient(3) - d.y * d.z * t4Coefficient(4)
                         - d.x * d.z * t4Coefficient(6));
  sum += 0.3153915653 * (2.0 * q.z - q.x - q.y) * t4Coefficient(5);
  return sum + 0.5462742153 * (q.x - q.y) * t4Coefficient(7);
}

vec3 t4Degree3(usampler2DArray high, int index, vec3 d) {
  t4Read(high, 3 * index, 0);
  t4Read(high, 3 * index + 1, 8);
  t4Read(high, 3 * index + 2, 16);
  vec3 q = d * d;
  vec3 sum = -0.5900435899 * d.y * (3.0 * q.x - q.y) * t4Coefficient(0);
  sum += 2.8906114426 * d.x * d.y * d.z * t4Coefficient(1);
  sum += -0.4570457995 * d.y * (4.0 * q.z - q.x - q.y) * t4Coefficient(2);
  sum += 0.3731763326 * d.z * (2.0 * q.z - 3.0 * q.x - 3.0 * q.y) * t4Coefficient(3);
  sum += -0.4570457995 * d.x * (4.0 * q.z - q.x - q.y) * t4Coefficient(4);
  sum += 1.4453057213 * d.z * (q.x - q.y) * t4Coefficient(5);
  return sum + -0.5900435899 * d.x * (q.x - 3.0 * q.y) * t4Coefficient(6);
}

float t4Slice(usampler2DArray motion, int index, vec4 when, float logTimeScale, inout vec3 mean) {
  vec4 m = uintBitsToFloat(texelFetch(motion, splatTexCoord(index), 0));
  float anchor = when.y > 0.0 ? clamp(m.w, 0.0, 1.0) : m.w;
  mean += m.xyz * (when.x - anchor);
  float sigmas = (when.x - m.w) * exp(-logTimeScale);
  float marginal = exp(-0.5 * sigmas * sigmas);
  return marginal < 0.05 ? 0.0 : marginal;
}
`;

/** Fills `splat` (a Gsplat) at `index`; `counts`: Gaussians with SH of degree 1, 2, 3. */
function statements(i: Record<string, string>, splat: string): string {
  return `
${splat}.flags = 0u;
${splat}.index = ${i.index};
uvec4 place = texelFetch(${i.place}, splatTexCoord(${i.index}), 0);
uvec4 look = texelFetch(${i.look}, splatTexCoord(${i.index}), 0);
vec2 opacityRed = unpackHalf2x16(look.x);
vec2 scaleTime = unpackHalf2x16(look.w);
vec3 mean = uintBitsToFloat(place.xyz);
vec4 rotation = t4Rotation(place.w);
float alpha = opacityRed.x;
if (${i.moving}) alpha *= t4Slice(${i.motion}, ${i.index}, ${i.when}, scaleTime.y, mean);
if (alpha > 0.0 && alpha >= ${i.when}.z) {
  if (${i.carried}) t4Carry(${i.bindings}, ${i.poses}, ${i.index}, mean, rotation);
  vec3 colour = 0.5 + 0.28209479177387814 * vec3(opacityRed.y, unpackHalf2x16(look.y));
  vec3 towards = normalize(mean - ${i.eye});
  ivec3 counts = ${i.counts} * ivec3(greaterThanEqual(vec3(${i.when}.w), vec3(1.0, 2.0, 3.0)));
  if (${i.index} < counts.x)
    colour += t4Degrees12(${i.low}, ${i.mid}, ${i.index}, counts.y, towards);
  if (${i.index} < counts.z) colour += t4Degree3(${i.high}, ${i.index}, towards);
  ${splat}.flags = GSPLAT_FLAG_ACTIVE;
  ${splat}.center = mean;
  ${splat}.scales = exp(vec3(unpackHalf2x16(look.z), scaleTime.x));
  ${splat}.quaternion = rotation;
  ${splat}.rgba = vec4(max(colour, 0.0) * ${i.light}, alpha);
}`;
}

function textureOf(words: Words["words"]): THREE.DataArrayTexture {
  const rows = words.length / (4 * ROW);
  const height = Math.min(rows, ROW);
  const texture = new THREE.DataArrayTexture(words, ROW, height, rows / height);
  texture.format = THREE.RGBAIntegerFormat;
  texture.type = THREE.UnsignedIntType;
  texture.internalFormat = "RGBA32UI";
  texture.needsUpdate = true;
  return texture;
}

/** In the place of what a block does not have; one for all, as a long clip has many blocks. */
const NOTHING = textureOf(new Uint32Array(4 * ROW));

/** A block that Spark can draw. Free it with dispose(). */
export class BlockSplats extends SplatGenerator {
  readonly memory: number;
  private readonly textures: THREE.DataArrayTexture[] = [];
  private readonly nodes: MotionNodes | null;
  private readonly poses: THREE.DataArrayTexture; // of the nodes, at the time of the last pose()
  private readonly poseFloats: Float32Array; // the same memory

  constructor(
    readonly packed: PackedBlock,
    private readonly slice: SliceUniforms,
  ) {
    super({ numSplats: packed.count });
    this.memory = memoryOf(packed);
    this.nodes = packed.nodes;
    const poses = poseTexels(packed.nodes);
    this.poseFloats = new Float32Array(poses.words.buffer);
    const textureFor = ({ words }: Words) => {
      if (words.length === 0) return NOTHING;
      const texture = textureOf(words);
      this.textures.push(texture);
      return texture;
    };
    this.poses = textureFor(poses);
    const samplerOf = (value: THREE.DataArrayTexture, key: string) =>
      new dyno.DynoUsampler2DArray({ value, key });
    const sampler = (words: Words, key: string) => samplerOf(textureFor(words), key);
    const uniforms = {
      place: sampler(packed.place, "place"),
      look: sampler(packed.look, "look"),
      motion: sampler(packed.motion, "motion"),
      bindings: sampler(packed.bindings, "bindings"),
      poses: samplerOf(this.poses, "poses"),
      low: sampler(packed.sh[0], "low"),
      mid: sampler(packed.sh[1], "mid"),
      high: sampler(packed.sh[2], "high"),
      counts: dyno.dynoIvec3(new THREE.Vector3(...packed.shCounts), "counts"),
      moving: dyno.dynoBool(packed.moving, "moving"),
      carried: dyno.dynoBool(packed.nodes !== null, "carried"),
      when: slice.when,
      eye: slice.eye,
      light: slice.light,
    };
    const transform = new SplatTransformer(); // of the object in the scene
    this.frameUpdate = () => {
      if (transform.update(this)) this.updateVersion();
    };
    this.generator = dyno.dynoBlock(
      { index: "int" },
      { gsplat: dyno.Gsplat },
      ({ index }) => {
        const { gsplat } = new dyno.Dyno({
          inTypes: {
            index: "int",
            place: "usampler2DArray",
            look: "usampler2DArray",
            motion: "usampler2DArray",
            bindings: "usampler2DArray",
            poses: "usampler2DArray",
            low: "usampler2DArray",
            mid: "usampler2DArray",
            high: "usampler2DArray",
            counts: "ivec3",
            moving: "bool",
            carried: "bool",
            when: "vec4",
            eye: "vec3",
            light: "vec3",
          },
          outTypes: { gsplat: dyno.Gsplat },
          inputs: { index, ...uniforms },
          globals: () => [dyno.defineGsplat, GLSL, CARRY_GLSL],
          statements: ({ inputs, outputs }) =>
            statements(inputs as Record<string, string>, outputs.gsplat!).split("\n"),
        }).outputs;
        return { gsplat: transform.applyGsplat(gsplat) };
      },
    );
  }

  /** The Gaussians, and motion nodes, are where the block's own time t has them from the next draw on. */
  pose(t: number): void {
    this.slice.when.value.x = t;
    if (this.nodes === null) return;
    writePoses(this.nodes, t, this.poseFloats);
    this.poses.needsUpdate = true;
  }

  dispose(): void {
    for (const texture of this.textures) texture.dispose();
    this.generator = undefined;
  }
}
