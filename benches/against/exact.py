"""llvmpipe's picture without its approximations of sRGB.

llvmpipe converts texels and pixels from and to sRGB by polynomials and powers that are off by up to a code of 8 bits. FLIP raises
small differences (an exponent of .7), so a code in a third of all channels is most of the distance between its picture and an exact
one. Here the same program draws into floats, from textures of floats: llvmpipe has nothing to convert then. Texels are made linear before
they are handed over, and the picture is made sRGB after it was read back, both by IEC 61966-2-1 in double precision.
"""
import json
import os
import subprocess
import tempfile

# What the program says, and what is put in its place. Each has to be there once.
CHANGES = [
    ("glTexImage2D(GL_TEXTURE_2D, 0, cfmt, imgs[i].w, imgs[i].h, 0, GL_RGBA, GL_UNSIGNED_BYTE, imgs[i].px);",
     """size_t texels = (size_t)imgs[i].w * imgs[i].h;
    float *linear = malloc(texels * 4 * sizeof *linear);
    for (size_t k = 0; k < texels * 4; k++) {
      double c = imgs[i].px[k] / 255.0;
      linear[k] = k % 4 == 3 ? c : c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
    }
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, imgs[i].w, imgs[i].h, 0, GL_RGBA, GL_FLOAT, linear);
    free(linear);"""),
    ("k ? 0 : msaa, cfmt, W, H)", "k ? 0 : msaa, GL_RGBA32F, W, H)"),
    ("if (cfmt == GL_SRGB8_ALPHA8) glEnable(GL_FRAMEBUFFER_SRGB);", ""),
    ("void *px = malloc(np * 4);", "void *px = malloc(np * 16);"),
    ("glReadPixels(0, 0, W, H, GL_RGBA, GL_UNSIGNED_BYTE, px);", "glReadPixels(0, 0, W, H, GL_RGBA, GL_FLOAT, px);"),
    ("fwrite((char *)px + (size_t)y * W * 4, 4, W, fo);", "fwrite((char *)px + (size_t)y * W * 16, 16, W, fo);"),
]


def picture(bench, scene, camera, aa, out):
    """Writes a .ppm of what llvmpipe draws, one frame, lambert."""
    with tempfile.TemporaryDirectory() as folder:
        dump = os.path.join(folder, "linear")
        args = [program(bench), "--scene", scene, "--camera", camera, "--frames", "1", "--warmup", "0",
                "--msaa", "4" if aa == "msaa4" else "0", "--cull", "--no-blend", "--dump", dump]
        subprocess.run(args, check=True, stdout=subprocess.DEVNULL)
        write(dump, camera, out)


def program(bench):
    """Built once for each version of the source, beside the program it is made from."""
    import llvmpipe_render
    exe = llvmpipe_render.build() + "_exact"
    source = os.path.join(bench, "llvmpipe_render.c")
    newest = max(os.path.getmtime(source), os.path.getmtime(__file__))
    if os.path.exists(exe) and os.path.getmtime(exe) >= newest:
        return exe
    with open(source) as f:
        text = f.read()
    for said, instead in CHANGES:
        if text.count(said) != 1:
            raise RuntimeError("%s no longer says, once: %s" % (source, said))
        text = text.replace(said, instead)
    changed = exe + ".c"
    with open(changed, "w") as f:
        f.write(text)
    subprocess.check_call(["gcc", "-O2", "-o", exe, changed, "-lEGL", "-lpng", "-ljpeg", "-lz", "-lm"])
    return exe


def write(dump, camera, out):
    """Linear RGBA of floats, rows from the top, as codes of sRGB."""
    import numpy
    with open(camera) as f:
        cam = json.load(f)
    width, height = cam.get("width", 1920), cam.get("height", 1080)
    rgb = numpy.fromfile(dump, numpy.float32).reshape(height, width, 4)[:, :, :3].astype(numpy.float64).clip(0, 1)
    codes = numpy.where(rgb <= .0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - .055)
    with open(out, "wb") as f:
        f.write(b"P6 %d %d 255\n" % (width, height))
        f.write((255 * codes + .5).astype(numpy.uint8).tobytes())
