// Starts "tissuec lsp" for files of tissuec. Highlighting works without it.
"use strict";

const vscode = require("vscode");

let client;

async function activate(context) {
  let node;
  try {
    node = require("vscode-languageclient/node");
  } catch (error) {
    vscode.window.showWarningMessage(
      'tissuec: run "npm install" in the folder of the extension to have the language server.'
    );
    return;
  }
  const settings = vscode.workspace.getConfiguration("tissuec");
  const command = settings.get("command", "tissuec");
  const server = { command, args: ["lsp"], transport: node.TransportKind.stdio };
  const selector = [
    { scheme: "file", language: "tissuec" },
    { scheme: "untitled", language: "tissuec" },
  ];
  client = new node.LanguageClient("tissuec", "tissuec", server, {
    documentSelector: selector,
    initializationOptions: { libraries: settings.get("libraries", []) },
    synchronize: { fileEvents: vscode.workspace.createFileSystemWatcher("**/*.{tis,csv,obj,stl,ply,vtk,vtu,msh,feb}") },
  });
  try {
    await client.start();
  } catch (error) {
    vscode.window.showErrorMessage(
      `tissuec: cannot start "${command} lsp". Is it installed? pip install "tissuec[lsp]"`
    );
  }
}

function deactivate() {
  return client && client.stop();
}

module.exports = { activate, deactivate };
