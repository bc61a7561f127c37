"""llvmpipe's picture as it would be without approximations of sRGB, and with samples where others have them.

It converts texels and pixels from and to sRGB by polynomials and powers that are off by up to a few codes of 8 bits, and FLIP raises small
differences (an exponent of .7). Here the same program draws into floats, from textures of floats: llvmpipe has nothing to convert then.
Texels are made linear before they are handed over, and the picture is made sRGB after it was read back, both by IEC 61966-2-1 in double
precision. What is not rounded to 8 bits then are samples, and levels of textures unless asked for.

Rows of OpenGL's pictures go up, and so do the places of its samples: in a picture whose rows go down they are mirrored. Here it is the scene
that is mirrored, so that samples lie as Direct3D and Vulkan have them.
"""
import json
import os
import subprocess
import tempfile

# How levels of textures are kept: as means, or each rounded to 8-bit sRGB, the next one made of that.
LEVELS = {"floats": 0, "codes": 1}

# Rows that go down.
DOWN = [
    ("gl_Position=vp*vec4(dot(r0,h),dot(r1,h),dot(r2,h),1.0);", "gl_Position=vp*vec4(dot(r0,h),dot(r1,h),dot(r2,h),1.0); gl_Position.y=-gl_Position.y;"),
    ("glFrontFace((lf = o->flip) ? GL_CW : GL_CCW);", "glFrontFace((lf = o->flip) ? GL_CCW : GL_CW);"),
    ("if (dump) { FILE *fo = fopen(dump, \"wb\"); for (int y = H - 1; y >= 0; y--)", "if (dump) { FILE *fo = fopen(dump, \"wb\"); for (int y = 0; y < H; y++)"),
]

# Nothing to convert. What the program says, and what is put in its place; each has to be there once.
EXACT = [
    ("static const char *VS =",
     """static double linear_of(double c) { return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4); }
static double code_of(double x) { return floor(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055) + 0.5); }
static const char *VS ="""),
    ("glTexImage2D(GL_TEXTURE_2D, 0, cfmt, imgs[i].w, imgs[i].h, 0, GL_RGBA, GL_UNSIGNED_BYTE, imgs[i].px);",
     """int w = imgs[i].w, h = imgs[i].h;
    float *level = malloc((size_t)w * h * 4 * sizeof *level);
    for (size_t k = 0; k < (size_t)w * h * 4; k++) level[k] = k % 4 == 3 ? imgs[i].px[k] / 255.0 : linear_of(imgs[i].px[k] / 255.0);
    for (int number = 0;; number++) {
      glTexImage2D(GL_TEXTURE_2D, number, GL_RGBA32F, w, h, 0, GL_RGBA, GL_FLOAT, level);
      if (w == 1 && h == 1) break;
      int sx = w > 1 ? 2 : 1, sy = h > 1 ? 2 : 1;  // sides are powers of two, or lose their last texel
      float *next = malloc((size_t)(w / sx) * (h / sy) * 4 * sizeof *next);
      for (int y = 0; y < h / sy; y++) for (int x = 0; x < w / sx; x++) for (int c = 0; c < 4; c++) {
        double sum = 0;
        for (int j = 0; j < sy; j++) for (int k = 0; k < sx; k++) sum += level[((size_t)(y * sy + j) * w + x * sx + k) * 4 + c];
        double mean = sum / (sx * sy);
        next[((size_t)y * (w / sx) + x) * 4 + c] = CODES && c < 3 ? linear_of(code_of(mean) / 255) : mean;
      }
      free(level); level = next; w /= sx; h /= sy;
    }
    free(level);"""),
    ("    glGenerateMipmap(GL_TEXTURE_2D);\n", ""),
    ("k ? 0 : msaa, cfmt, W, H)", "k ? 0 : msaa, GL_RGBA32F, W, H)"),
    ("if (cfmt == GL_SRGB8_ALPHA8) glEnable(GL_FRAMEBUFFER_SRGB);", ""),
    ("void *px = malloc(np * 4);", "void *px = malloc(np * 16);"),
    ("glReadPixels(0, 0, W, H, GL_RGBA, GL_UNSIGNED_BYTE, px);", "glReadPixels(0, 0, W, H, GL_RGBA, GL_FLOAT, px);"),
    ("fwrite((char *)px + (size_t)y * W * 4, 4, W, fo);", "fwrite((char *)px + (size_t)y * W * 16, 16, W, fo);"),
]


def picture(bench, scene, camera, aa, levels, out):
    """Writes a .ppm of what llvmpipe draws with rows that go down, one frame, lambert; exactly, but for `levels` None."""
    with tempfile.TemporaryDirectory() as folder:
        dump = os.path.join(folder, "dump")
        args = [program(bench, levels), "--scene", scene, "--camera", camera, "--frames", "1", "--warmup", "0",
                "--msaa", "4" if aa == "msaa4" else "0", "--cull", "--no-blend", "--dump", dump]
        subprocess.run(args, check=True, stdout=subprocess.DEVNULL)
        write(dump, camera, levels, out)


def program(bench, levels):
    """Built once for each version of the source, beside the program it is made from."""
    import llvmpipe_render
    exe = "%s_down_%s" % (llvmpipe_render.build(), levels or "as_is")
    source = os.path.join(bench, "llvmpipe_render.c")
    newest = max(os.path.getmtime(source), os.path.getmtime(__file__))
    if os.path.exists(exe) and os.path.getmtime(exe) >= newest:
        return exe
    with open(source) as f:
        text = f.read()
    for said, instead in DOWN + (EXACT if levels else []):
        if text.count(said) != 1:
            raise RuntimeError("%s no longer says, once: %s" % (source, said))
        text = text.replace(said, instead)
    with tempfile.TemporaryDirectory(dir=os.path.dirname(exe)) as folder:
        changed, built = os.path.join(folder, "exact.c"), os.path.join(folder, "exact")
        with open(changed, "w") as f:
            f.write(text)
        subprocess.check_call(["gcc", "-O3", "-march=native", "-DCODES=%d" % LEVELS.get(levels, 0), "-o", built, changed, "-lEGL", "-lpng", "-ljpeg", "-lz", "-lm"])
        os.replace(built, exe)
    return exe


def write(dump, camera, levels, out):
    """RGBA of 8 bits, or linear in floats if it is exact, as codes of sRGB."""
    import numpy
    with open(camera) as f:
        cam = json.load(f)
    width, height = cam.get("width", 1920), cam.get("height", 1080)
    rgb = numpy.fromfile(dump, numpy.float32 if levels else numpy.uint8).reshape(height, width, 4)[:, :, :3]
    if levels:
        rgb = rgb.astype(numpy.float64).clip(0, 1)
        codes = numpy.where(rgb <= .0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - .055)
        rgb = (255 * codes + .5).astype(numpy.uint8)
    with open(out, "wb") as f:
        f.write(b"P6 %d %d 255\n" % (width, height))
        f.write(rgb.tobytes())
