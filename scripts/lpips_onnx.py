#!/usr/bin/env python3
"""Writes the LPIPS network as an ONNX file for `tessera evaluate --lpips`.

    lpips_onnx.py [--net alex|vgg] FILE.onnx

Needs PyTorch, torchvision, lpips and onnx (docs/howto/lpips.md). The file has two inputs, float
[1, 3, height, width] with any height and width, RGB in [-1, 1], and one value.
"""
import argparse

import lpips
import torch


class Distance(torch.nn.Module):
    """One number of two images."""

    def __init__(self, net):
        super().__init__()
        self.network = lpips.LPIPS(net=net, verbose=False).eval()

    def forward(self, drawn, truth):
        return self.network(drawn, truth).reshape(1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--net", choices=("alex", "vgg"), default="alex")
    parser.add_argument("file")
    asked = parser.parse_args()
    sides = {2: "height", 3: "width"}
    images = torch.zeros(1, 3, 256, 320), torch.zeros(1, 3, 256, 320)
    # the exporter before dynamo: OpenCV reads what it writes
    torch.onnx.export(Distance(asked.net), images, asked.file, input_names=["drawn", "truth"],
                      output_names=["distance"], dynamic_axes={"drawn": sides, "truth": sides},
                      opset_version=12, dynamo=False)


if __name__ == "__main__":
    main()
